"""HEPLP: the entropy of the second of two Hough maps, for parallel lines (Lee et al. 2013, eq. 10-14).

doi:10.1109/TBME.2013.2261816. A cell of HEwG's map is a line L. For each of a number of directions w, M is
the line through P, the picture's top left corner, with normal direction w; L and M meet in V, and the line
through V and Q, the picture's centre, has some direction too, rho. (w, rho) stands for V, and is bounded
where V is not: H2 gathers there the votes of all lines through V, as parallel lines all go through their
vanishing point. The entropy of H2 is minimised.

What the article leaves open, and what is done here: the line of a cell is the one through its middle;
DIRECTIONS samples of w and RHOS cells of rho over half a turn, since in wider ones neighbouring lines would
count as one, and models that draw lines together would win; eq. 13's second vector ends in -r, not r
(x cos t + y sin t = r is (cos t, sin t, -r)); points that the model cannot undistort, or whose line passes
farther than FARTHEST times the frame's diagonal from P, vote for cells of their own.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..straightness import Floats
from .entropy import entropy
from .grid import Measure, over_grid
from .tangents import Tangents

Cells = NDArray[np.uint8]

ANGLES = 180
STEP = 2.0
DIRECTIONS = 90
RHOS = 250
FARTHEST = 3.0
# The second map costs DIRECTIONS votes a cell of the first.
MOST_POINTS = 4000


def prepare(points: Floats, gradients: Floats, size: tuple[float, float]) -> Measure:
    """Return the measure over edge points (n, 2) px with gradients (n, 2); ``size`` of the frame, px."""
    tangents = Tangents.of(points, gradients)
    step = STEP * max(1.0, size[1] / 540)
    half = int(np.ceil(FARTHEST * np.hypot(*size) / step))
    q = ((size[0] - 1) / 2, (size[1] - 1) / 2)
    second = SecondMap(q, DIRECTIONS, RHOS)
    table = _of_every_cell(second, step, half)

    def cost(lam: float, cx: float, cy: float) -> float:
        phi, r = tangents.under(lam, cx, cy)
        # From here on offsets are from P, the centre of the top left pixel.
        r += np.float32(cx) * np.cos(phi) + np.float32(cy) * np.sin(phi)
        row = np.minimum((phi * np.float32(ANGLES / np.pi)).astype(np.int64), ANGLES - 1)
        column = np.floor(r / np.float32(step)) + half
        inside = (column >= 0) & (column < 2 * half)
        cells = row[inside] * (2 * half) + column[inside].astype(np.int64)
        cells, votes = np.unique(cells, return_counts=True)
        alone = len(points) - int(np.count_nonzero(inside))
        return entropy(second.count(table[cells], votes), alone=alone * DIRECTIONS)

    return over_grid(cost)


def _of_every_cell(second: SecondMap, step: float, half: int) -> Cells:
    """The cells of rho, (ANGLES * 2 * half, DIRECTIONS), of the line in the middle of each cell of H1."""
    theta = np.asarray((np.arange(ANGLES) + 0.5) * (np.pi / ANGLES), np.float64)
    offset = np.asarray((np.arange(2 * half) - half + 0.5) * step, np.float64)
    table = np.empty((ANGLES, 2 * half, DIRECTIONS), np.uint8)
    for i, angle in enumerate(theta):
        table[i] = second.cells_of(np.full(2 * half, angle), offset)
    return table.reshape(-1, DIRECTIONS)


class SecondMap:
    """H2 for P at the origin and Q at ``q`` (x, y) px: ``directions`` of w by up to 255 ``cells`` of rho."""

    def __init__(self, q: tuple[float, float], directions: int, cells: int) -> None:
        self.q = q
        self.omega = (np.arange(directions) * (np.pi / directions)).astype(np.float32)
        self.cells = cells

    def votes(self, theta: Floats, r: Floats, votes: NDArray[np.intp]) -> Floats:
        """Return H2, (directions, cells), where line i (its normal's angle, its offset px) has votes[i]."""
        return self.count(self.cells_of(theta, r), votes)

    def cells_of(self, theta: Floats, r: Floats) -> Cells:
        """Return the cell of rho, (n, directions), for each w, of lines (normal's angle, offset px)."""
        cosine, sine = np.cos(self.omega), np.sin(self.omega)
        t, offset = theta.astype(np.float32)[:, None], r.astype(np.float32)[:, None]
        # V = (cos w, sin w, 0) x (cos t, sin t, -r) of eq. 13: P is the origin, so eq. 14 gives 0.
        v1, v2 = -offset * sine, offset * cosine
        v3 = np.sin(t) * cosine - np.cos(t) * sine
        # Eq. 12 and 11: n = (x_Q, y_Q, 1) x V, and rho its angle.
        rho = np.arctan2(np.float32(self.q[1]) * v3 - v2, v1 - np.float32(self.q[0]) * v3)
        rho *= np.float32(self.cells / np.pi)
        return (np.floor(rho).astype(np.int16) % self.cells).astype(np.uint8)

    def count(self, cells: Cells, votes: NDArray[np.intp]) -> Floats:
        """Return H2 where the line with ``cells[i]`` (directions,) has votes[i]."""
        directions = len(self.omega)
        place = cells + np.arange(directions, dtype=np.int32) * self.cells
        weights = np.repeat(votes.astype(np.float64), directions)
        held = np.bincount(place.ravel(), weights, directions * self.cells)
        return np.asarray(held.reshape(directions, self.cells), np.float64)
