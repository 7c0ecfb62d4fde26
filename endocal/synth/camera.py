"""From light to the recorded picture: vignetting, blur, gamma, field stop, noise, JPEG."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from ..errors import UsageError

Picture = NDArray[np.uint8]
Light = NDArray[np.float32]


@dataclass(frozen=True)
class ContentCircle:
    """The round field stop of an endoscope.

    ``center`` (x, y) in px; ``diameter`` in px of the frame's height, measured where the grey level above
    black has fallen to half; ``softness`` is the width in px over which it falls, at least one pixel.
    """

    center: tuple[float, float]
    diameter: float
    softness: float = 1.5

    def transmission(self, size: tuple[int, int], pixel_aspect: float = 1.0) -> Light:
        """Return the share of the grey level that passes at each pixel, float32 (h, w)."""
        r = np.sqrt(squared_radius(size, self.center, pixel_aspect))
        return np.clip((self.diameter / 2 - r) / max(self.softness, 1.0) + 0.5, 0, 1)


@dataclass(frozen=True)
class Camera:
    """What the optics, the sensor and the recorder do to the light, in this order.

    ``vignetting``: the share of light lost at ``vignetting_radius`` px from the circle's (else the frame's)
    centre, growing with the radius squared. ``blur``: sigma of the point spread in px. ``tint``: gains of
    blue, green and red, or None to leave the light as it is (grey light then makes a grey picture).
    ``gamma``: a grey level is 255 * light^(1/gamma). ``black``: the lowest grey level. ``noise``: sigma in
    grey levels. ``jpeg``: quality from 1 to 100, or None for no compression.
    """

    blur: float = 0.7
    vignetting: float = 0.0
    vignetting_radius: float | None = None
    gamma: float = 1.0
    black: float = 0.0
    noise: float = 0.0
    tint: tuple[float, float, float] | None = None
    jpeg: int | None = None

    def __post_init__(self) -> None:
        if not (0 <= self.blur <= 100 and 0 <= self.noise <= 255 and 0 <= self.black < 255):
            raise UsageError(
                "blur lies from 0 to 100 px, noise and black from 0 to 255 grey levels"
            )
        if not (0 <= self.vignetting <= 1 and 0.1 <= self.gamma <= 10):
            raise UsageError("vignetting lies from 0 to 1, gamma from 0.1 to 10")
        if self.jpeg is not None and not 1 <= self.jpeg <= 100:
            raise UsageError(f"JPEG quality {self.jpeg}: it lies from 1 to 100")

    @property
    def reach(self) -> int:
        """How far beyond the frame light still reaches into it, in px."""
        return math.ceil(4 * self.blur)

    def focus(
        self, light: Light, circle: ContentCircle | None = None, pixel_aspect: float = 1.0
    ) -> Light:
        """Dim light (h, w, ...) toward the rim, blur it, and cut off ``reach`` px on each side.

        In this order: lamp and lens take light from rays, before these meet a little beside their place.
        """
        k = self.reach
        if self.vignetting:
            light = light * _like(self._gain(light.shape[:2], circle, pixel_aspect), light)
        if self.blur == 0:
            return light
        soft = cv2.GaussianBlur(light, (2 * k + 1, 2 * k + 1), self.blur)
        return np.ascontiguousarray(soft[k:-k, k:-k])

    def _gain(
        self, shape: tuple[int, ...], circle: ContentCircle | None, pixel_aspect: float
    ) -> Light:
        """The share of the light (h, w) that is left in a frame widened by ``reach`` px on each side."""
        k = self.reach
        h, w = shape[0] - 2 * k, shape[1] - 2 * k
        x, y = circle.center if circle else ((w - 1) / 2, (h - 1) / 2)
        radius = self.vignetting_radius or math.hypot(w * pixel_aspect, h) / 2
        far = squared_radius((shape[1], shape[0]), (x + k, y + k), pixel_aspect)
        return np.maximum(1 - self.vignetting / radius**2 * far, 0)

    def expose(
        self,
        light: Light,
        circle: ContentCircle | None,
        pixel_aspect: float,
        rng: np.random.Generator,
    ) -> Light:
        """Turn focused light (h, w) or (h, w, 3) into noisy grey levels, float32, not yet rounded."""
        h, w = light.shape[:2]
        if self.tint is not None:
            gray = light[..., None] if light.ndim == 2 else light
            light = gray * np.array(self.tint, np.float32)
        level = np.clip(light, 0, 1)
        if self.gamma != 1:
            cv2.pow(level, 1 / self.gamma, level)
        if circle:
            # After gamma, so that the circle's edge lies where it is stated, as one sees and measures it.
            level *= _like(circle.transmission((w, h), pixel_aspect), level)
        level *= 255 - self.black
        level += self.black
        if self.noise:
            grain = rng.standard_normal((h, w), dtype=np.float32)
            grain *= self.noise
            level += _like(grain, level)
        return level

    def compress(self, picture: Picture) -> Picture:
        """Pass a picture through JPEG at ``jpeg``, if that is set."""
        if self.jpeg is None:
            return picture
        _, packed = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, self.jpeg])
        return np.asarray(cv2.imdecode(packed, cv2.IMREAD_UNCHANGED), np.uint8)


def _like(field: Light, picture: Light) -> Light:
    """Give a field (h, w) the dimensions of a picture."""
    return field if picture.ndim == 2 else field[..., None]


def to_grey_levels(level: Light) -> Picture:
    """Round grey levels to uint8."""
    return np.asarray(cv2.convertScaleAbs(np.maximum(level, 0)), np.uint8)


def squared_radius(
    size: tuple[int, int], center: tuple[float, float], pixel_aspect: float = 1.0
) -> Light:
    """Squared distance of each pixel from ``center``, float32 (h, w), in square px."""
    x = (np.arange(size[0]) - center[0]) * pixel_aspect
    y = np.arange(size[1]) - center[1]
    return ((x * x)[None, :] + (y * y)[:, None]).astype(np.float32)
