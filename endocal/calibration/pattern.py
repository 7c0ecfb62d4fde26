"""Which lines belong to the pattern, and which are one line found twice."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from .profiles import Measured
from .straightness import Floats, Labels, Undistorted, fit_lines

# A side must hold for this many profiles in a row to count as a square of a chessboard.
SHORTEST_RUN = 4
# A line of a chessboard changes sides at least this often, and a board shows at least this many lines.
FEWEST_CHANGES = 3
FEWEST_BOARD_LINES = 6
# Lines that cross are measured up to a few px from the crossing, where the edge is weak.
CROSSING = 8.0


def board_lines(measured: Measured) -> NDArray[np.bool_]:
    """Which lines (n,) are a chessboard's, if a chessboard is there; else all.

    Other straight things in the room may help to calibrate, but they may also be bent, or be the rim's;
    what changes sides again and again, each time where another such line crosses, is the pattern.
    """
    places, owner = _changes_of_side(measured)
    count = int(measured.labels.max()) + 1
    board = np.bincount(owner, minlength=count) >= FEWEST_CHANGES
    for _ in range(2):
        if np.count_nonzero(board) < FEWEST_BOARD_LINES:
            return np.ones(count, bool)
        crossed = _near_another(places, owner, measured, board)
        board &= np.bincount(owner[crossed], minlength=count) >= FEWEST_CHANGES
    return board if np.count_nonzero(board) >= FEWEST_BOARD_LINES else np.ones(count, bool)


def _changes_of_side(measured: Measured) -> tuple[Floats, Labels]:
    """Places (m, 2) px where lines change their bright side, and the lines (m,)."""
    new_line = np.diff(measured.labels, prepend=-1) != 0
    starts = np.flatnonzero(new_line | (np.diff(measured.sides, prepend=0) != 0))
    ends = np.append(starts[1:], len(measured.labels))
    keep = ends - starts >= SHORTEST_RUN
    starts, ends = starts[keep], ends[keep]
    label, side = measured.labels[starts], measured.sides[starts]
    changed = (label[1:] == label[:-1]) & (side[1:] != side[:-1])
    before, after = measured.points[ends[:-1] - 1], measured.points[starts[1:]]
    return ((before + after) / 2)[changed], label[1:][changed]


def _near_another(
    places: Floats, owner: Labels, measured: Measured, board: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Which places lie within CROSSING px of a measured point of another line of the board."""
    on_board = board[measured.labels]
    points, labels = measured.points[on_board], measured.labels[on_board]
    tree = cKDTree(points)
    neighbors = tree.query_ball_point(places, CROSSING)
    return np.array(
        [np.any(labels[near] != own) for near, own in zip(neighbors, owner, strict=True)], bool
    )


def merge_twins(points: Floats, labels: Labels, params: Floats, distance: float) -> Labels:
    """Give one label to lines that run within ``distance`` px of each other where they overlap.

    Noise can split the points of one line among two; measured twice, they would count twice.
    """
    count = int(labels.max()) + 1
    under = Undistorted.of(points, params)
    lines = fit_lines(under.u, labels, count, under.denominator**2)
    order = np.argsort(-np.bincount(labels, minlength=count))
    becomes = np.arange(count)
    scale = under.scale(lines.normals[labels])
    for position, i in enumerate(order):
        if becomes[i] != i:
            continue
        turned = np.abs(lines.normals @ lines.normals[i])
        for j in order[position + 1 :]:
            if becomes[j] != j or turned[j] < 0.97:
                continue
            mine = labels == j
            off = np.abs(under.u[mine] @ lines.normals[i] - lines.offsets[i]) / scale[mine]
            if np.quantile(off, 0.8) < distance:
                becomes[j] = i
    return np.unique(becomes[labels], return_inverse=True)[1].astype(np.intp)
