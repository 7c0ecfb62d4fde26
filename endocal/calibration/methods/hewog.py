"""HEwoG: Hough entropy without gradients, every point voting for all directions (Lee et al. 2013, eq. 2-6).

doi:10.1109/TBME.2013.2261816. The article's baseline, degenerate by its own account (Fig. 1): where a
model shrinks or spreads the picture, the number of empty cells changes, and the entropy with it.

What it leaves open, and what is done here: directions in the middle of ANGLES cells over half a turn;
offsets from the distortion centre in cells of STEP px (of a frame of 540 lines, more in a larger one), out
to twice the points' reach; votes that fall farther out, where a strong model throws them, are left out
of the map, as a fixed accumulator leaves them out.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..straightness import LEAST_DENOMINATOR, Floats
from .entropy import entropy
from .grid import Measure, over_grid

ANGLES = 180
STEP = 2.0
# Offsets that the map holds, as a multiple of the points' reach.
FARTHEST = 2.0
# Every point costs as much as ANGLES points of HEwG.
MOST_POINTS = 2000


def prepare(points: Floats, gradients: Floats, size: tuple[float, float]) -> Measure:
    """Return the measure over edge points (n, 2) px; their gradients do not count."""
    middle = (points.max(axis=0) + points.min(axis=0)) / 2
    reach = float(np.linalg.norm(points - middle, axis=1).max())
    step = STEP * max(1.0, size[1] / 540)
    half = int(np.ceil(FARTHEST * reach / step))

    def cost(lam: float, cx: float, cy: float) -> float:
        return entropy(vote_map(undistorted(points, lam, cx, cy), ANGLES, step, half))

    return over_grid(cost)


def undistorted(points: Floats, lam: float, cx: float, cy: float) -> Floats:
    """Return the offsets (m, 2) px from the centre of undistorted points (eq. 4); none past the fold."""
    d = points - (cx, cy)
    denominator = 1 + lam * np.einsum("ij,ij->i", d, d)
    held = denominator > LEAST_DENOMINATOR
    return d[held] / denominator[held, None]


def vote_map(offsets: Floats, angles: int, step: float, half: int) -> NDArray[np.intp]:
    """Return the votes (angles, 2 * half) of points at ``offsets`` (n, 2) px, one for every direction.

    Cell (i, j) holds the lines x cos t + y sin t = r with t in the middle of the i-th of ``angles`` parts of
    half a turn, and r in [(j - half) step, (j + 1 - half) step).
    """
    t = (np.arange(angles) + 0.5) * (np.pi / angles)
    normals = np.stack([np.cos(t), np.sin(t)]).astype(np.float32) / np.float32(step)
    column = offsets.astype(np.float32) @ normals
    # A column at either side takes what lies outside, and is dropped again.
    column += np.float32(half + 1)
    np.clip(column, 0, 2 * half + 1, out=column)
    cells = column.astype(np.intp)
    cells += np.arange(angles) * (2 * half + 2)
    votes = np.bincount(cells.ravel(), minlength=angles * (2 * half + 2))
    return votes.reshape(angles, 2 * half + 2)[:, 1:-1]
