"""A cavity of tissue in front of a moving endoscope: texture, vessels, relief, wet highlights.

Unlike a board it is no measure of anything: it is sampled from a painted texture. What is exact is the
geometry: each pixel's ray, by the lens's own model, is followed to the surface in three dimensions, so that
camera motion makes parallax as it does in life, and zoom does not.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from .camera import Light
from .noise import fractal_noise
from .rays import Rays

Field = NDArray[np.float32]

# Half the side of the painted square, in units of the usual distance from lens to tissue.
_EXTENT = 1.8
# Linear radiances, BGR.
_MUCOSA = (0.13, 0.16, 0.48)
_DEEP = (0.05, 0.05, 0.30)
_FAT = (0.16, 0.42, 0.66)
_VESSEL = (0.03, 0.02, 0.28)


@dataclass(frozen=True)
class Eye:
    """Where the lens is, in units of the usual distance to the tissue, and its turn in degrees.

    ``position`` (x, y, z): z towards the tissue. ``yaw`` turns to the right, ``pitch`` down, ``roll``
    turns the picture.
    """

    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    yaw: float = 0.0
    pitch: float = 0.0
    roll: float = 0.0

    @property
    def rotation(self) -> NDArray[np.float64]:
        """(3, 3), from the eye's axes to the cavity's."""
        (cy, sy), (cp, sp), (cr, sr) = (
            (math.cos(math.radians(a)), math.sin(math.radians(a)))
            for a in (self.yaw, self.pitch, self.roll)
        )
        turn = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
        nod = np.array([[1, 0, 0], [0, cp, sp], [0, -sp, cp]])
        return turn @ nod @ np.array([[cr, -sr, 0], [sr, cr, 0], [0, 0, 1]])


@dataclass(frozen=True)
class Organ:
    """A ball before the wall, its middle (x, y, z) from the lens at rest; in units of the usual distance."""

    center: tuple[float, float, float]
    radius: float

    def met(
        self, directions: tuple[Field, Field, Field], start: tuple[float, float, float]
    ) -> Field:
        """Return how far rays go until they meet it, in lengths of the direction; NaN where they do not."""
        to = [c - s for c, s in zip(self.center, start, strict=True)]
        a = sum(d * d for d in directions)
        b = sum(d * t for d, t in zip(directions, to, strict=True))
        c = sum(t * t for t in to) - self.radius**2
        with np.errstate(invalid="ignore"):
            return np.asarray((b - np.sqrt(b * b - a * c)) / a, np.float32)


class Tissue:
    """The painted surface z = 1 - bowl (x^2 + y^2) + relief(x, y), the same for the same ``seed``.

    ``texels`` is how finely it is painted: the number of texels on each side. ``organs`` stand before it;
    they are painted and shaded as the wall is at the same (x, y).
    """

    def __init__(
        self, seed: int, texels: int, bowl: float = 0.5, organs: tuple[Organ, ...] = ()
    ) -> None:
        rng = np.random.default_rng(seed)
        self._bowl = bowl
        self._organs = organs
        self._relief = fractal_noise(rng, (512, 512), {6: 0.10, 14: 0.05, 30: 0.015})
        self._paint = _paint(rng, texels)
        bumps = fractal_noise(rng, (1024, 1024), {15: 0.04, 35: 0.02, 90: 0.008, 220: 0.002})
        bumps += cv2.resize(self._relief, (1024, 1024), interpolation=cv2.INTER_CUBIC)
        texel = 2 * _EXTENT / 1024
        slopes = [cv2.Sobel(bumps, cv2.CV_32F, dx, 1 - dx, scale=0.125 / texel) for dx in (1, 0)]
        self._slopes = -np.dstack(slopes)

    def light(self, rays: Rays, eye: Eye) -> Light:
        """Radiance along each ray, float32 (h, w, 3) BGR; black where a ray sees nothing.

        The lamp is at the eye: what is near and faces it is bright.
        """
        turn = eye.rotation.astype(np.float32)
        blind = np.isnan(rays.x)
        rx, ry = np.where(blind, 0, rays.x), np.where(blind, 0, rays.y)
        dx, dy, dz = (turn[i, 0] * rx + turn[i, 1] * ry + turn[i, 2] for i in range(3))
        x, y, t = self._meet(dx, dy, dz, eye.position)
        color = self._look_up(self._paint, x, y).astype(np.float32)
        slope = self._look_up(self._slopes, x, y)
        nx, ny = 2 * self._bowl * x + slope[..., 0], 2 * self._bowl * y + slope[..., 1]
        length = np.sqrt(dx * dx + dy * dy + dz * dz)
        facing = np.maximum((nx * dx + ny * dy + dz) / (length * np.sqrt(nx * nx + ny * ny + 1)), 0)
        # Falls with the square of the distance; the automatic exposure keeps the middle in range.
        lamp = facing / np.maximum(t * length, 0.3) ** 2
        light = color * (lamp / 255)[..., None]
        light += (0.8 * lamp * np.exp(-900 * (1 - facing)))[..., None]
        light[blind] = 0
        return light

    def _meet(
        self, dx: Field, dy: Field, dz: Field, start: tuple[float, float, float]
    ) -> tuple[Field, Field, Field]:
        """Follow rays to the surface: its (x, y) there, and the distance in lengths of the direction.

        Against the bowl alone that is a quadratic equation; a few turns with the relief found there bring
        in the relief.
        """
        sx, sy, sz = start
        a = self._bowl * (dx * dx + dy * dy)
        b = dz + 2 * self._bowl * (sx * dx + sy * dy)
        c = sz + self._bowl * (sx * sx + sy * sy) - 1
        relief: Field = np.zeros_like(dx)
        for _ in range(3):
            with np.errstate(invalid="ignore", divide="ignore"):
                # The stable root of a t^2 + b t + c - relief = 0, for a near 0 too.
                t = -2 * (c - relief) / (b + np.sqrt(np.maximum(b * b - 4 * a * (c - relief), 0)))
            x, y = (np.asarray(v, np.float32) for v in (sx + t * dx, sy + t * dy))
            relief = self._look_up(self._relief, x, y)
        for organ in self._organs:
            nearer = organ.met((dx, dy, dz), start)
            hit = (nearer > 0) & (nearer < t)
            t = np.where(hit, nearer, t)
            x, y = np.where(hit, sx + t * dx, x), np.where(hit, sy + t * dy, y)
        return x, y, np.asarray(t, np.float32)

    @staticmethod
    def _look_up(image: NDArray, x: Field, y: Field) -> NDArray:
        """Read the square picture ``image`` of the surface at (x, y); its sides go on for ever."""
        n = image.shape[0]
        scale, middle = np.float32(n / (2 * _EXTENT)), np.float32((n - 1) / 2)
        # Not left to the border mode alone: far off, coordinates overflow the look-up's integers.
        across, down = (np.clip(v * scale + middle, -1, n) for v in (x, y))
        return cv2.remap(image, across, down, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)


def texels_for(focal: float) -> int:
    """Return how many texels a side show one to the pixel through a lens of this focal length, px."""
    return int(np.clip(math.ceil(focal * 2 * _EXTENT), 512, 4096))


def _paint(rng: np.random.Generator, texels: int) -> NDArray[np.uint8]:
    """Paint the albedo, uint8 (texels, texels, 3) BGR, linear."""
    size = (texels, texels)
    color = np.empty((texels, texels, 3), np.float32)
    color[:] = _MUCOSA
    _mix(color, _DEEP, _step(fractal_noise(rng, size, {5: 1.0, 11: 0.6, 23: 0.3}), 0.1, 0.9))
    _mix(color, _FAT, _step(fractal_noise(rng, size, {7: 1.0, 15: 0.7, 40: 0.3}), 0.55, 0.8))
    for cells, width, depth in ((5, 0.010, 0.9), (11, 0.005, 0.7), (26, 0.0025, 0.5)):
        field = fractal_noise(rng, size, {cells: 1.0, 3 * cells: 0.35})
        _mix(color, _VESSEL, depth * _along_zeros(field, width * texels / (2 * _EXTENT)))
    mottle = fractal_noise(rng, size, {60: 0.10, 150: 0.10, 400: 0.10, 900: 0.06})
    color *= 1 + mottle[..., None]
    return np.asarray(cv2.convertScaleAbs(np.maximum(color, 0), alpha=255), np.uint8)


def _mix(color: Field, other: tuple[float, float, float], share: Field) -> None:
    for channel, value in enumerate(other):
        color[..., channel] += share * (value - color[..., channel])


def _step(field: Field, low: float, high: float) -> Field:
    s = np.clip((field - low) / (high - low), 0, 1)
    return s * s * (3 - 2 * s)


def _along_zeros(field: Field, width: float) -> Field:
    """Curves that wind like vessels: 1 on the zero lines of a smooth field, gone ``width`` px from them."""
    gx, gy = (cv2.Sobel(field, cv2.CV_32F, dx, 1 - dx, scale=0.125) for dx in (1, 0))
    distance = field / np.maximum(np.sqrt(gx * gx + gy * gy), 1e-6)
    return np.exp(-((distance / width) ** 2))
