"""Places of one picture found again in another."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

Luma = NDArray[np.uint8]
# (n, 1, 2) px, as OpenCV has them.
Places = NDArray[np.float32]

# The side of the patch that makes a corner, px.
_BLOCK = 5
# The part of the strongest corner's strength that is tried first; in most pictures enough reach it.
_USUAL = 0.005
# With less than this part of the corners that are sought, softer ones count as well.
_FEW = 0.4
# No corner at all is as weak.
_NONE = 1e-12
# The mean and the standard deviation of an evened picture: few of its values fall outside 0 to 255.
_EVEN = (128.0, 40.0)


def best_corners(image: Luma, count: int, spacing: float, worth: float) -> Places:
    """Find the ``count`` strongest corners that are ``spacing`` px apart, (n, 1, 2) px.

    A bright highlight or an instrument is so much stronger than soft tissue that little else is left where
    the strongest is the measure: there they count from ``worth`` of the picture's median on.
    """
    corners = cv2.goodFeaturesToTrack(image, count, _USUAL, spacing, blockSize=_BLOCK)
    if corners is None or len(corners) < _FEW * count:
        strength = cv2.cornerMinEigenVal(image, _BLOCK)
        level = worth * float(np.median(strength)) / max(float(strength.max()), _NONE)
        if 0 < level < _USUAL:
            corners = cv2.goodFeaturesToTrack(image, count, level, spacing, blockSize=_BLOCK)
    return np.empty((0, 1, 2), np.float32) if corners is None else np.asarray(corners, np.float32)


def follow_places(
    last: Luma, current: Luma, places: Places, window: int = 17, levels: int = 3
) -> tuple[Places, NDArray[np.bool_]]:
    """Follow places by Lucas and Kanade's method, there and back; those that do not come back are lost.

    What lies within a ``window`` px wide is compared, in the pictures and in ``levels`` halved ones.
    """
    settings: dict[str, Any] = {
        "winSize": (window, window),
        "maxLevel": levels,
        "criteria": (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 15, 0.02),
    }
    # OpenCV takes None for places that it is to make room for, whatever its annotations say.
    empty: Any = None
    moved, there, _ = cv2.calcOpticalFlowPyrLK(last, current, places, empty, **settings)
    returned, back, _ = cv2.calcOpticalFlowPyrLK(current, last, moved, empty, **settings)
    apart = np.linalg.norm(returned - places, axis=(1, 2))
    found = (there[:, 0] > 0) & (back[:, 0] > 0) & (apart < 0.3)
    return np.asarray(moved, np.float32), found


def evened(image: Luma) -> Luma:
    """Return the picture in a usual light and contrast, so that smoke and lamps change little."""
    values = image.astype(np.float32)
    mean, deviation = float(values.mean()), max(float(values.std()), 1.0)
    even = (values - mean) * (_EVEN[1] / deviation) + _EVEN[0]
    return np.clip(even, 0, 255).astype(np.uint8)
