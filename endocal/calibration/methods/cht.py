"""CHT: the entropy of the second of two cascaded Hough transforms (Tuytelaars et al. 1998).

T. Tuytelaars, L. Van Gool, M. Proesmans, T. Moons, "The cascaded Hough transform as an aid in aerial image
interpretation", Proc. ICCV (1998) 67-72, doi:10.1109/ICCV.1998.710702: with lines written a x + b + y = 0,
points (x, y) and lines (a, b) change places under one and the same transform, so that it can be repeated
on its own result. Each plane is kept bounded by splitting it in three squares: (a, b) where both are
at most 1, (1/a, b/a) where a is the largest of 1, a and b, and (1/b, a/b) where b is. The second
transform gathers lines that meet in one point, finite or not.

What the sources leave open, and what is done here: the cascade serves as a measure through the entropy of its
second map, as HEPLP's does; an edge point votes in the first map once, by its undistorted gradient, as for
HEwG, and no peaks are picked in between; the origin is the frame's centre and the unit half its diagonal;
FIRST and SECOND cells along a side of each square; points that a model cannot undistort vote for cells of
their own. In homogeneous coordinates the three squares are the faces of half a cube.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from ..straightness import Floats
from .entropy import entropy
from .grid import Measure, over_grid
from .tangents import Tangents

Faces = NDArray[np.intp]

FIRST = 240
SECOND = 48
# The second map costs 3 * SECOND votes a cell of the first.
MOST_POINTS = 3000


def prepare(points: Floats, gradients: Floats, size: tuple[float, float]) -> Measure:
    """Return the measure over edge points (n, 2) px with gradients (n, 2); ``size`` of the frame, px."""
    tangents = Tangents.of(points, gradients)
    table = _table()
    middle, unit = ((size[0] - 1) / 2, (size[1] - 1) / 2), float(np.hypot(*size)) / 2

    def cost(lam: float, cx: float, cy: float) -> float:
        phi, r = tangents.under(lam, cx, cy)
        nx, ny = np.cos(phi), np.sin(phi)
        r += np.float32(cx - middle[0]) * nx + np.float32(cy - middle[1]) * ny
        # The line nx x + ny y - r = 0 is (a, 1, b) up to its scale.
        cells, votes = np.unique(
            face_cells(np.stack([nx, ny, -r / np.float32(unit)], axis=1), FIRST),
            return_counts=True,
        )
        alone = len(points) - len(phi)
        places = table[cells].ravel()
        weights = np.repeat(votes.astype(np.float64), table.shape[1])
        held = np.bincount(places, weights, 3 * SECOND**2 + 1)[:-1]
        return entropy(held, alone=alone * 1.5 * SECOND)

    return over_grid(cost)


def face_cells(homogeneous: NDArray[np.floating], side: int) -> Faces:
    """Return the cell (n,), of 3 * side^2, of each point or line (n, 3), known up to its scale.

    The face is that of the coordinate of the largest size; its first coordinate is the next one divided by
    it, its second the one after that.
    """
    face = np.abs(homogeneous).argmax(axis=1)
    rows = np.arange(len(face))
    largest = homogeneous[rows, face]
    u = homogeneous[rows, (face + 1) % 3] / largest
    v = homogeneous[rows, (face + 2) % 3] / largest
    i, j = (np.minimum(((w + 1) * (side / 2)).astype(np.int64), side - 1) for w in (u, v))
    return np.asarray((face * side + i) * side + j, np.intp)


def face_points(cells: Faces, side: int) -> Floats:
    """Return the middles of cells (n,) in homogeneous coordinates (n, 3)."""
    face, i, j = cells // side**2, cells // side % side, cells % side
    out = np.empty((len(cells), 3))
    rows = np.arange(len(cells))
    out[rows, face] = 1.0
    out[rows, (face + 1) % 3] = (2 * i + 1) / side - 1
    out[rows, (face + 2) % 3] = (2 * j + 1) / side - 1
    return out


def second_cells(lines: Floats, side: int) -> NDArray[np.int16]:
    """Return the cells of the second map, of 3 * side^2, that lines (n, 3) vote for: (n, 3 * side).

    On each face a line is followed along the axis that it is nearer to: one cell a step. Steps that leave
    the face are 3 * side^2.
    """
    steps = (2 * np.arange(side, dtype=np.float32) + 1) / side - 1
    out = np.empty((len(lines), 3, side), np.int16)
    for face in range(3):
        p, q, s = (lines[:, (face + k) % 3].astype(np.float32) for k in (1, 2, 0))
        steep = np.abs(p) > np.abs(q)
        along, across = np.where(steep, q, p), np.where(steep, p, q)
        with np.errstate(divide="ignore", invalid="ignore"):
            slope, start = -along / across, -s / across
            other = start[:, None] + slope[:, None] * steps
        inside = np.abs(other) < 1
        column = ((np.where(inside, other, 0) + 1) * np.float32(side / 2)).astype(np.int32)
        step = np.arange(side, dtype=np.int32)
        i = np.where(steep[:, None], column, step)
        j = np.where(steep[:, None], step, column)
        out[:, face] = np.where(inside, (face * side + i) * side + j, 3 * side**2)
    return out.reshape(len(lines), 3 * side)


@cache
def _table() -> NDArray[np.int16]:
    """The cells of the second map that the middle of each cell of the first votes for."""
    return np.concatenate(
        [
            second_cells(face_points(part, FIRST), SECOND)
            for part in np.split(np.arange(3 * FIRST**2), FIRST)
        ]
    )
