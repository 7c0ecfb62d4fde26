"""The frame in which a boundary is sought: its luma, whatever its depth, and the shape of its pixels."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

Luma = NDArray[np.uint8] | NDArray[np.uint16]


class Frame(NamedTuple):
    """A picture's luma, (h, w); ``unit`` is how many of its levels make one of 8 bit."""

    luma: Luma
    unit: int
    pixel_aspect: float

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in px."""
        return self.luma.shape[1], self.luma.shape[0]

    @property
    def square_size(self) -> tuple[float, float]:
        """Width and height in px of the height."""
        return self.luma.shape[1] * self.pixel_aspect, float(self.luma.shape[0])


def frame_of(image: NDArray[np.uint8] | NDArray[np.uint16], pixel_aspect: float) -> Frame:
    """Make a frame of (h, w) luma or a (h, w, 3) BGR picture, uint8 or uint16.

    A 16-bit array may hold any depth: the one that its brightest value needs is taken.
    """
    luma: Luma = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY) if image.ndim == 3 else image  # type: ignore[assignment]
    if luma.dtype == np.uint8:
        return Frame(luma, 1, pixel_aspect)
    # A few lines tell the depth as well as all of them; black ones are 8 bit as much as any other.
    brightest = int(luma[:: max(luma.shape[0] // 64, 1)].max())
    return Frame(luma, 1 << max(brightest.bit_length() - 8, 0), pixel_aspect)
