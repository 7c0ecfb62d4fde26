"""How straight a model makes the rows and columns of a chessboard's corners, found without it."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from ..model import DivisionModel

Corners = NDArray[np.float64]

# Boards of at least so many inner corners are looked for, the largest first; more are found where they are.
_LEAST_BOARDS = ((5, 4), (4, 3), (3, 3))


def straightness(corners: Corners, model: DivisionModel | None = None) -> float:
    """Return the root mean square distance, px, of ``corners`` (rows, cols, 2) from straight lines.

    Each row and each column is fitted by total least squares, after the corners were undistorted by
    ``model`` and scaled back to their mean spacing before. Infinite where the model cannot undistort one.
    """
    if model is None:
        return _rms_of_lines(corners)
    undistorted = model.undistort(corners)
    if not np.all(np.isfinite(undistorted)):
        return math.inf
    return _rms_of_lines(undistorted * (mean_spacing(corners) / mean_spacing(undistorted)))


def mean_spacing(corners: Corners) -> float:
    """Return the mean distance, px, between neighbours along rows and columns."""
    along = [np.linalg.norm(np.diff(corners, axis=axis), axis=-1).ravel() for axis in (0, 1)]
    return float(np.concatenate(along).mean())


def as_grid(corners: Corners, counts: tuple[int, int]) -> Corners:
    """Arrange a list of corners (n, 2), row by row, as (rows, cols, 2).

    ``counts`` are those along rows and columns in either order: neighbours tell which.
    """
    a, b = counts
    grids = [corners.reshape(shape) for shape in ((a, b, 2), (b, a, 2))]
    return min(grids, key=lambda g: float(np.linalg.norm(np.diff(g, axis=1), axis=-1).mean()))


def find_corners(grey: NDArray[np.uint8]) -> Corners | None:
    """Find the inner corners of the largest chessboard in a picture (h, w): (rows, cols, 2) px, or None."""
    flags = cv2.CALIB_CB_LARGER | cv2.CALIB_CB_EXHAUSTIVE | cv2.CALIB_CB_ACCURACY
    flags |= cv2.CALIB_CB_NORMALIZE_IMAGE
    for least in _LEAST_BOARDS:
        found, corners, grid = cv2.findChessboardCornersSBWithMeta(grey, least, flags)
        if found:
            return as_grid(np.asarray(corners, np.float64).reshape(-1, 2), grid.shape[:2])
    return None


def _rms_of_lines(corners: Corners) -> float:
    squares, count = 0.0, 0
    for lines in (corners, corners.swapaxes(0, 1)):
        centred = lines - lines.mean(axis=1, keepdims=True)
        # The least singular value of a line's points is the length of the vector of their distances to it.
        squares += float((np.linalg.svd(centred, compute_uv=False)[:, -1] ** 2).sum())
        count += lines.shape[0] * lines.shape[1]
    return math.sqrt(squares / count)
