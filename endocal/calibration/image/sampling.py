"""Grey levels between the pixels, and of several pixels together."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

# cv2.remap takes no more columns than a short can count.
_COLUMNS = 4096


def sample(image: NDArray[np.float32], points: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return ``image`` (h, w) at ``points`` (..., 2) in px, bilinear, its edge repeated outside: (...)."""
    flat = points.reshape(-1, 2).astype(np.float32)
    rows = -(-len(flat) // _COLUMNS)
    grid = np.zeros((rows * _COLUMNS, 2), np.float32)
    grid[: len(flat)] = flat
    x, y = grid.reshape(rows, _COLUMNS, 2).transpose(2, 0, 1).copy()
    values = cv2.remap(
        image,
        x,
        y,
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_REPLICATE,
    )
    return np.asarray(values, np.float32).reshape(-1)[: len(flat)].reshape(points.shape[:-1])


def sample_smoothly(image: NDArray[np.float32], points: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return ``image`` (h, w) at ``points`` (..., 2) px, smoothed by a cubic B-spline: (...).

    It is smoothed alike wherever a point lies between the pixels, by a variance of 1/3 px^2, and taken at the
    very point: ``sample`` rounds to 1/32 px, and moves a sharp edge by up to 0.03 px to and fro. It takes ten
    times as long.
    """
    at = points.reshape(-1, 2).T[::-1]
    values = map_coordinates(image, at, np.float32, order=3, mode="nearest", prefilter=False)
    return np.asarray(values).reshape(points.shape[:-1])


def reduced(image: NDArray[np.float32], step: int) -> NDArray[np.float32]:
    """Return ``image`` (h, w) ``step`` times smaller, (h // step, w // step), each pixel a mean of many."""
    if step == 1:
        return image
    h, w = (side // step for side in image.shape)
    whole = image[: h * step, : w * step]
    return np.asarray(cv2.resize(whole, (w, h), interpolation=cv2.INTER_AREA), np.float32)


def to_reduced(points: NDArray[np.float64], step: int) -> NDArray[np.float64]:
    """Where ``points`` (..., 2) px of a picture lie in the ``reduced`` one, px."""
    return (points + 0.5) / step - 0.5


def from_reduced(points: NDArray[np.float64], step: int) -> NDArray[np.float64]:
    """Where ``points`` (..., 2) px of a ``reduced`` picture lie in the whole one, px."""
    return (points + 0.5) * step - 0.5
