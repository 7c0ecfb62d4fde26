"""Whether the circle can still be where the last one was seen, by what a picture shows outside it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..boundary.circle import Boundary

Luma = NDArray[np.uint8] | NDArray[np.uint16]

# Every so many pixels each way are enough.
_EVERY = 8
# What lies within so many radii is not clearly outside: the fastest zoom goes on by 6 % a frame.
_NEAR = 1.15
# Inside, likewise: the rim's own softness and the dark next to it are left out.
_WITHIN = 0.8
# Less of a frame than this tells nothing.
_LEAST = 0.05
# A value belongs to the picture from this part of the way between the outside and the inside on.
_BRIGHT = 0.25
# So much of the outside has to be bright: panels, logos and glare take less.
_SHARE = 0.5


class SeenCircle:
    """The circle that was seen last, and the frame, (h, w), that showed it."""

    def __init__(self, luma: Luma, boundary: Boundary, pixel_aspect: float) -> None:
        self._picture = luma[::_EVERY, ::_EVERY].copy()
        self._boundary, self._aspect = boundary, pixel_aspect

    def is_outgrown(self, luma: Luma, diameter: float) -> bool:
        """Say whether a frame is bright where a circle of a ``diameter``, px, would leave it black."""
        now, radii = luma[::_EVERY, ::_EVERY], self._radii()
        outside = now[radii > _NEAR * diameter / 2]
        if now.shape != radii.shape or outside.size < _LEAST * now.size:
            return False
        bright = self._bright(radii)
        return bright is not None and float((outside > bright).mean()) > _SHARE

    def _bright(self, radii: NDArray[np.float64]) -> float | None:
        """Return the value from which on a picture shows something; None where the circle left none black."""
        seen, radius = self._picture, self._boundary.diameter / 2
        inside, outside = seen[radii < _WITHIN * radius], seen[radii > _NEAR * radius]
        if outside.size < _LEAST * seen.size or not inside.size:
            return None
        black, light = float(np.median(outside)), float(np.median(inside))
        return black + _BRIGHT * (light - black)

    def _radii(self) -> NDArray[np.float64]:
        """Return how far the pixels are from the circle's centre, px of the height."""
        y, x = np.ogrid[: self._picture.shape[0], : self._picture.shape[1]]
        across = (x * _EVERY - self._boundary.center[0]) * self._aspect
        return np.asarray(np.hypot(across, y * _EVERY - self._boundary.center[1]))
