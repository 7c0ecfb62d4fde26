"""A fisheye lens: angles from the axis mapped to radii by a law, which no division model follows exactly.

For pictures that show how calibration does on lenses that depart from its model.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import UsageError
from ..model import Points

Floats = NDArray[np.float64]

# The radius over the focal length, by the angle from the axis in radians.
PROJECTIONS: dict[str, Callable[[Floats], Floats]] = {
    "equidistant": lambda t: t,
    "equisolid": lambda t: 2 * np.sin(t / 2),
    "stereographic": lambda t: 2 * np.tan(t / 2),
    "orthographic": np.sin,
}
# The law is tabulated at so many squared radii; between them it is off by 1e-9 of the radius.
_NODES = 20_000
# Directions farther from the axis than this, radians, have no place on a plane before the lens.
_WIDEST = math.radians(89.9)


@dataclass(frozen=True)
class Fisheye:
    """Radius = ``focal`` px times g(angle), of a named projection or of the series of Kannala and Brandt.

    ``k``: where given, g(t) = t + k[0] t^3 + k[1] t^5 + … instead (2006, doi:10.1109/TPAMI.2006.153).
    ``center`` (x, y) px, ``size`` (width, height) px, ``pixel_aspect``: a pixel's width over its height.
    Undistorted points are those of a camera without distortion and of the same focal length.
    Raises UsageError for an unknown projection.
    """

    projection: str
    focal: float
    center: tuple[float, float]
    size: tuple[int, int]
    pixel_aspect: float = 1.0
    k: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if self.projection not in PROJECTIONS:
            raise UsageError(f"projection {self.projection!r} is none of {', '.join(PROJECTIONS)}")

    def radius(self, angle: Floats) -> Floats:
        """Return the radii, px, at which directions ``angle`` radians off the axis are seen."""
        if not self.k:
            return np.asarray(self.focal * PROJECTIONS[self.projection](angle))
        series = sum(k * angle ** (2 * i + 3) for i, k in enumerate(self.k))
        return np.asarray(self.focal * (angle + series))

    @property
    def valid_radius(self) -> float:
        """The distorted radius, px, up to which a point has a place before the lens."""
        return float(self._law[2])

    def undistort(self, points: ArrayLike) -> Points:
        """Map distorted points (..., 2) px to undistorted ones; NaN at ``valid_radius`` and beyond."""
        d = np.asarray(points, np.float64) - self.center
        q = (d[..., 0] * self.pixel_aspect) ** 2 + d[..., 1] ** 2
        out = d / self.denominator(q)[..., None] + self.center
        out[q >= self.valid_radius**2] = np.nan
        return out

    def distort(self, points: ArrayLike) -> Points:
        """Map undistorted points (..., 2) px to distorted ones."""
        d = np.asarray(points, np.float64) - self.center
        r = np.hypot(d[..., 0] * self.pixel_aspect, d[..., 1])
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.where(r > 0, self.radius(np.arctan(r / self.focal)) / r, 1.0)
        return np.asarray(d * ratio[..., None] + self.center)

    def denominator(self, q: NDArray[np.floating]) -> NDArray[np.floating]:
        """Distorted over undistorted radius, by the squared distorted radius in square px."""
        squared, ratio, _ = self._law
        return np.interp(q, squared, ratio).astype(q.dtype)

    @cached_property
    def _law(self) -> tuple[Floats, Floats, float]:
        """Squared distorted radii in even steps, the denominator at each, and the largest radius."""
        angle = np.linspace(0, _WIDEST, 4 * _NODES)[1:]
        radius = self.radius(angle)
        turns = np.flatnonzero(np.diff(radius) <= 0)
        last = int(turns[0]) + 1 if len(turns) else len(radius)
        angle, radius = angle[:last], radius[:last]
        squared = np.linspace(0, radius[-1] ** 2, _NODES)
        ratio = np.interp(squared, radius**2, radius / (self.focal * np.tan(angle)))
        return squared, ratio, float(radius[-1])
