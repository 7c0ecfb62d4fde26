"""Residuals of places some of which move on their own."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]

_TUKEY = 4.685
# The median of a two-dimensional normal residual's length is so many standard deviations.
_MEDIAN_LENGTH = 1.1774


def spread(vectors: Points) -> float:
    """Return the standard deviation of normal vectors (n, 2), by the median of their lengths."""
    return math.sqrt(float(np.median((vectors**2).sum(axis=1)))) / _MEDIAN_LENGTH


def biweight(residual: Points, scale: float) -> NDArray[np.float64]:
    """Return Tukey's weight (n,) of residuals (n, 2) whose standard deviation is ``scale``."""
    return np.asarray(
        np.maximum(1 - (residual**2).sum(axis=1) / (_TUKEY * scale) ** 2, 0) ** 2, np.float64
    )
