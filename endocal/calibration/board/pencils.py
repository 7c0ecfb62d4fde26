"""The lines of a flat, regular grid as a picture without distortion shows them: two pencils.

Rows and columns are printed at one distance from the next on a plane. In homogeneous coordinates line k of a
family f is then a_f - k v: a_f is its line number 0, and v, which both families share, is the horizon of the
plane (Hartley and Zisserman 2004, sections 8.6 and 2.3). Nine numbers up to their scale, as a homography has.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

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

    def lines(self, families: Labels, numbers: Labels) -> Floats:
        """Return the lines (n, 3) of these families and numbers: unit normals, and minus the offsets, px."""
        k = (numbers - self.middle[families]) / self.spread
        first, second, horizon = self.vector.reshape(3, 3)
        found = np.where(families[:, None] == 0, first, second) - k[:, None] * horizon
        found = found * (1.0, 1.0, self.reach)
        return np.asarray(found / np.maximum(np.hypot(*found.T[:2]), 1e-300)[:, None])


def pencils_through(
    normals: Floats, offsets: Floats, families: Labels, numbers: Labels, reach: float
) -> tuple[Pencils, Floats]:
    """Return the grid nearest to lines of known numbers, and the ways (8, 9) in which its vector may move.

    Lines are given by ``normals`` (n, 2) and ``offsets`` (n,) px; at least five, of both families. What is
    made small is algebraic, so that the grid is a start to go downhill from.
    """
    middle = np.array([np.mean(_ends(numbers[families == f])) for f in (0, 1)])
    spread = max(float(np.abs(numbers - middle[families]).max()), 1.0)
    k = (numbers - middle[families]) / spread
    line = np.column_stack([normals, -offsets / reach])
    # A line is what the grid has for it where the cross product of the two is zero.
    cross = np.cross(np.eye(3)[None], line[:, None]).transpose(0, 2, 1)
    parts = [cross * (families == 0)[:, None, None], cross * (families == 1)[:, None, None]]
    rows = np.concatenate([*parts, -k[:, None, None] * cross], axis=2).reshape(-1, 9)
    ways = np.linalg.svd(rows, full_matrices=False)[2]
    return Pencils(ways[-1], reach, middle, spread), ways[:-1]


def _ends(numbers: Labels) -> Floats:
    return np.array([numbers.min(), numbers.max()], np.float64)
