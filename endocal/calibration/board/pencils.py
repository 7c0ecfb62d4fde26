"""The lines of a flat, regular grid as a picture without distortion shows them: two pencils.

Rows and columns are printed at one distance from the next on a plane. In homogeneous coordinates line k of a
family f is then a_f - k v: a_f is its line number 0, and v, which both families share, is the horizon of the
plane (Hartley and Zisserman 2004, sections 8.6 and 2.3). Nine numbers up to their scale, as a homography has.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..straightness import Floats, Labels


@dataclass(frozen=True)
class Pencils:
    """A grid: ``vector`` (9,), (a_0, a_1, v) for coordinates and line numbers in units of their own.

    ``reach`` px is the unit of coordinates; ``middle`` (2,) and ``spread`` are the number of each family that
    counts as 0, and what counts as 1.
    """

    vector: Floats
    reach: float
    middle: Floats
    spread: float

    def lines(self, families: Labels, numbers: Floats) -> Floats:
        """Return the lines (n, 3) of these families and numbers: unit normals, and minus the offsets, px."""
        k = (numbers - self.middle[families]) / self.spread
        first, second, horizon = self.vector.reshape(3, 3)
        found = np.where(families[:, None] == 0, first, second) - k[:, None] * horizon
        found = found * (1.0, 1.0, self.reach)
        return np.asarray(found / np.maximum(np.hypot(*found.T[:2]), 1e-300)[:, None])

    def numbers_at(self, points: Floats, family: int = 0) -> Floats:
        """Return the numbers (n,) of a family's lines through ``points`` (n, 2) px; whole ones on its own."""
        at = np.column_stack([points / self.reach, np.ones(len(points))])
        first, second, horizon = self.vector.reshape(3, 3)
        with np.errstate(divide="ignore", invalid="ignore"):
            k = at @ (second if family else first) / (at @ horizon)
        return np.asarray(k * self.spread + self.middle[family])


def pencils_through(
    lines: Floats, families: Labels, numbers: Floats, placed: NDArray[np.bool_], reach: float
) -> tuple[Pencils, Floats, Floats]:
    """Return the grid nearest to lines, the ways (w, 9) in which its vector may move, and all lines' numbers.

    ``lines`` (n, 3): unit normals and minus the offsets, px. Those that are ``placed`` (n,) have ``numbers``,
    of family 0, or of both; with none of family 1 its first line takes number 0 there. Five or more are
    needed. What is made small is algebraic, so that the grid is a start to go downhill from.
    """
    line = lines / (1.0, 1.0, reach)
    middle = np.array([_middle(numbers[placed & (families == f)]) for f in (0, 1)])
    spread = max(float(np.abs(numbers - middle[families])[placed].max()), 1.0)
    k = (numbers - middle[families]) / spread
    # A line is what the grid has for it where the cross product of the two is zero.
    cross = np.cross(np.eye(3)[None], line[:, None]).transpose(0, 2, 1)
    of = [placed & (families == f) for f in (0, 1)]
    parts = [cross * own[:, None, None] for own in of]
    rows = np.concatenate([*parts, -k[:, None, None] * cross], axis=2)[placed].reshape(-1, 9)
    if of[1].any():
        ways = np.linalg.svd(rows, full_matrices=False)[2]
        return Pencils(ways[-1], reach, middle, spread), ways[:-1], numbers.astype(np.float64)
    known = np.r_[0:3, 6:9]
    own = np.linalg.svd(rows[:, known], full_matrices=False)[2]
    vector = np.zeros(9)
    vector[known] = own[-1]
    ways = np.zeros((5, 9))
    ways[:, known] = own[:-1]
    others = np.flatnonzero(~placed)
    if len(others) == 0:
        return Pencils(vector, reach, middle, spread), ways, numbers.astype(np.float64)
    # The other family's first line, which may turn and move, but whose length is nothing.
    vector[3:6] = line[others[0]]
    more = np.zeros((2, 9))
    more[:, 3:6] = np.linalg.svd(vector[None, 3:6])[2][1:]
    horizon = np.cross(line[others], vector[6:9])
    first = np.cross(line[others], vector[3:6])
    found = numbers.astype(np.float64)
    found[others] = spread * np.sum(first * horizon, axis=1) / np.sum(horizon**2, axis=1)
    return Pencils(vector, reach, middle, spread), np.concatenate([ways, more]), found


def _middle(numbers: Floats) -> float:
    return float(numbers.min() + numbers.max()) / 2 if len(numbers) else 0.0
