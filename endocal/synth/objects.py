"""What stands between the lens and the scene: instruments, and their specular highlights."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .camera import Light
from .rays import Rays
from .sampling import Coordinates


@dataclass(frozen=True)
class Instrument:
    """A round, straight shaft that reaches from outside the picture to its tip.

    ``tip`` (x, y) is the direction in which the tip is seen, in tangents of angles from the optical axis
    (undistorted px over the focal length); ``angle`` points from the tip to the handle, in degrees from
    the x axis towards the y axis; ``width`` is the shaft's at the tip, in the same tangents, and grows by
    ``taper`` of itself per unit of length towards the handle, which is nearer. ``radiance`` is that of the
    dark shaft, 0 to 1; the last ``jaw`` widths of it are of metal and ``shine``. Its edges are straight
    lines of the scene.
    """

    tip: tuple[float, float]
    angle: float
    width: float
    taper: float = 0.3
    radiance: float = 0.04
    shine: float = 0.5
    jaw: float = 2.5

    def covers(self, x: Coordinates, y: Coordinates) -> NDArray[np.bool_]:
        """Which directions (x, y), in tangents, it hides."""
        depth, _, _ = self._inside(x, y)
        with np.errstate(invalid="ignore"):
            return np.asarray(depth > 0)

    def paint(self, light: Light, rays: Rays) -> None:
        """Cover light (h, w) or (h, w, 3) with it, in place; edges are smooth over a pixel."""
        depth, u, along = self._inside(rays.x, rays.y)
        with np.errstate(invalid="ignore"):
            share = np.clip(depth / rays.footprint + 0.5, 0, 1)
        where = np.nonzero(share > 0)  # False for NaN
        cover, u, along = share[where], np.clip(u[where], -1, 1), along[where]
        metal = along < self.jaw * self.width
        level = np.where(metal, 0.5 * self.shine, self.radiance) * (0.3 + 0.7 * np.sqrt(1 - u * u))
        # The light comes from the lens; a round shaft throws it back along one line.
        level += np.where(metal, self.shine, 0.3 * self.shine) * np.exp(-(((u + 0.3) / 0.15) ** 2))
        if light.ndim == 3:
            level, cover = level[:, None], cover[:, None]
        light[where] += (cover * (level - light[where])).astype(np.float32)

    def _inside(
        self, x: Coordinates, y: Coordinates
    ) -> tuple[Coordinates, Coordinates, Coordinates]:
        """Depth within the outline, place across the shaft (-1 to 1), and distance from the tip."""
        c, s = math.cos(math.radians(self.angle)), math.sin(math.radians(self.angle))
        dx, dy = x - self.tip[0], y - self.tip[1]
        along, across = dx * c + dy * s, dy * c - dx * s
        half = self.width / 2 * (1 + self.taper * np.maximum(along, 0))
        return np.minimum(half - np.abs(across), along), across / half, along


@dataclass(frozen=True)
class MovingInstrument:
    """An instrument whose tip goes to and fro: by ``reach`` (x, y), in ``period`` s, from ``phase`` on.

    ``phase`` is in parts of a period; the two axes move at slightly different rates.
    """

    instrument: Instrument
    reach: tuple[float, float]
    period: float
    phase: float = 0.0

    def at(self, time: float) -> Instrument:
        """Return the instrument as it stands at ``time``, s."""
        turn = 2 * math.pi * (time / self.period + self.phase)
        x, y = self.instrument.tip
        tip = x + self.reach[0] * math.sin(turn), y + self.reach[1] * math.sin(1.3 * turn + 1)
        return replace(self.instrument, tip=tip)


@dataclass(frozen=True)
class Highlight:
    """A specular reflection: a Gaussian of ``sigma`` px at ``center`` that adds ``strength`` radiance."""

    center: tuple[float, float]
    sigma: float
    strength: float

    def add_to(self, light: Light, origin: tuple[int, int]) -> None:
        """Add it in place to light (h, w) or (h, w, 3) that begins at the frame's pixel ``origin``."""
        h, w = light.shape[:2]
        x, y = self.center[0] - origin[0], self.center[1] - origin[1]
        reach = 5 * self.sigma
        left, right = max(0, int(x - reach)), min(w, int(x + reach) + 2)
        top, bottom = max(0, int(y - reach)), min(h, int(y + reach) + 2)
        if left >= right or top >= bottom:
            return
        gx = np.exp(-0.5 * ((np.arange(left, right) - x) / self.sigma) ** 2)
        gy = np.exp(-0.5 * ((np.arange(top, bottom) - y) / self.sigma) ** 2)
        glow = (self.strength * np.outer(gy, gx)).astype(np.float32)
        light[top:bottom, left:right] += glow if light.ndim == 2 else glow[..., None]
