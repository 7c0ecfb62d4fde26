"""Frames that repeat the one before: a recording at 15 frames per second that was stored at 25, say.

Such a frame is no second look at the circle, and tells of no zoom that came to rest.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Luma = NDArray[np.uint8] | NDArray[np.uint16]

# Every so many pixels each way are enough to tell two pictures apart.
_EVERY = 4


@dataclass(frozen=True)
class RepeatSpec:
    """What counts as the same picture.

    A repeated frame that was coded anew differs, on average over its pixels, by less than ``differs`` of
    the picture's standard deviation: by up to 0.2 %, and one with noise and motion of its own by
    1.7 % and more. At most so ``many`` frames that follow repeat one; what stays the same for longer shows a
    scene at rest.
    """

    differs: float = 0.01
    many: int = 3


class Repeats:
    """Tells the frames that repeat the one before."""

    def __init__(self, spec: RepeatSpec = RepeatSpec()) -> None:
        self._spec = spec
        self._last: Luma | None = None
        self._number = 0

    def has(self, luma: Luma) -> bool:
        """Say whether the next frame, (h, w) uint8 or uint16, repeats the last that did not."""
        spec, last = self._spec, self._last
        current = luma[::_EVERY, ::_EVERY]
        if last is not None and last.dtype == current.dtype and self._number < spec.many:
            apart = float(cv2.mean(cv2.absdiff(current, last))[0])
            # One without any contrast repeats nothing: black is black.
            if apart < spec.differs * float(cv2.meanStdDev(last)[1][0, 0]):
                self._number += 1
                return True
        self._last, self._number = current.copy(), 0
        return False
