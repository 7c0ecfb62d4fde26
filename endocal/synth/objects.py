"""What stands between the lens and the pattern: instruments and specular highlights."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model import DivisionModel
from .sampling import Coordinates


@dataclass(frozen=True)
class Instrument:
    """A straight shaft that reaches from outside the picture to its tip.

    ``tip`` (x, y) is in distorted px; ``angle`` is the direction from the tip to the handle, in degrees
    from the x axis towards the y axis; ``width`` is in undistorted px at the tip and grows by ``taper``
    per px towards the handle, which is nearer. ``radiance`` is its body's, 0 to 1; a stripe along the
    middle third reflects ``shine`` instead. Its edges are straight lines of the scene.
    """

    tip: tuple[float, float]
    angle: float
    width: float
    taper: float = 0.0005
    radiance: float = 0.06
    shine: float = 0.3

    @property
    def radiances(self) -> tuple[float, float, float]:
        """The radiances of the labels 1, 2 and 3 of ``parts``: one side, the stripe, the other side."""
        return (self.radiance, self.shine, self.radiance * 0.6)

    def parts(self, x: Coordinates, y: Coordinates, model: DivisionModel) -> NDArray[np.int32]:
        """Label undistorted offsets (x, y) from the distortion centre, in square px: 0 is beside it."""
        tip = ((model.undistort(self.tip) - model.center) * (model.pixel_aspect, 1.0)).tolist()
        c, s = math.cos(math.radians(self.angle)), math.sin(math.radians(self.angle))
        with np.errstate(invalid="ignore"):
            along = (x - tip[0]) * c + (y - tip[1]) * s
            across = (y - tip[1]) * c - (x - tip[0]) * s
            half = self.width / 2 * (1 + self.taper * along)
            inside = (along > 0) & (np.abs(across) < half)
            part = 1 + (across > -half / 3).astype(np.int32) + (across > half / 3)
        return np.where(inside, part, 0).astype(np.int32)


@dataclass(frozen=True)
class Highlight:
    """A specular reflection: a Gaussian of ``sigma`` px at ``center`` that adds ``strength`` radiance."""

    center: tuple[float, float]
    sigma: float
    strength: float

    def add_to(self, light: NDArray[np.float32], origin: tuple[int, int]) -> None:
        """Add it in place to ``light`` (h, w), whose first pixel is at the frame's pixel ``origin``."""
        h, w = light.shape
        x, y = self.center[0] - origin[0], self.center[1] - origin[1]
        reach = 5 * self.sigma
        left, right = max(0, int(x - reach)), min(w, int(x + reach) + 2)
        top, bottom = max(0, int(y - reach)), min(h, int(y + reach) + 2)
        if left >= right or top >= bottom:
            return
        gx = np.exp(-0.5 * ((np.arange(left, right) - x) / self.sigma) ** 2)
        gy = np.exp(-0.5 * ((np.arange(top, bottom) - y) / self.sigma) ** 2)
        light[top:bottom, left:right] += (self.strength * np.outer(gy, gx)).astype(np.float32)
