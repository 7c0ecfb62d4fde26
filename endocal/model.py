"""The division model of radial lens distortion (Fitzgibbon 2001; Lee et al. 2013, eq. 1, 4, 7).

Points are (x, y) in pixels, (0, 0) being the centre of the top-left pixel. With d = x_d - center and
r_d its length in square pixels (x multiplied by the pixel aspect):

    x_u = center + d / (1 + lam r_d^2 + lam2 r_d^4)

``lam2`` is zero in the article's one-parameter model. The magnification at the centre is 1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import InputError

Points = NDArray[np.float64]

# Two frame shapes count as the same when their aspect ratios differ by less than this: 1 px of rounding
# on the short side of a small frame.
_ASPECT_TOLERANCE = 0.01
# A model's parts, and how many numbers each is.
_PARTS = {"lam": 1, "center": 2, "size": 2, "pixel_aspect": 1, "lam2": 1}


@dataclass(frozen=True)
class DivisionModel:
    """A division model and the frame that it holds for.

    ``lam`` is in px^-2 and ``lam2`` in px^-4 (pixels of the frame's height), ``center`` is (x, y) in px,
    ``size`` is (width, height) in px, ``pixel_aspect`` is a pixel's width over its height.
    Raises InputError where a value is not finite or the centre lies more than a frame's size outside it.
    """

    lam: float
    center: tuple[float, float]
    size: tuple[int, int]
    pixel_aspect: float = 1.0
    lam2: float = 0.0

    def __post_init__(self) -> None:
        for name, count in _PARTS.items():
            value = getattr(self, name)
            if not _are_finite(value if count > 1 else (value,), count):
                numbers = "two finite numbers" if count > 1 else "a finite number"
                raise InputError(f"the model's {name} is {value!r}, not {numbers}")
        w, h = self.size
        if w < 1 or h < 1 or w != int(w) or h != int(h):
            raise InputError(f"the model's size {w}x{h} is not a frame size in whole pixels")
        if self.pixel_aspect <= 0:
            raise InputError(f"pixel_aspect {self.pixel_aspect:g} is not positive")
        cx, cy = self.center
        if not (-w <= cx <= 2 * w and -h <= cy <= 2 * h):
            raise InputError(f"the centre ({cx:g}, {cy:g}) lies far outside the {w}x{h} frame")
        # Plain Python numbers, so that equality, repr and TOML never meet a NumPy scalar.
        object.__setattr__(self, "lam", float(self.lam))
        object.__setattr__(self, "lam2", float(self.lam2))
        object.__setattr__(self, "center", (float(cx), float(cy)))
        object.__setattr__(self, "size", (int(w), int(h)))
        object.__setattr__(self, "pixel_aspect", float(self.pixel_aspect))

    @property
    def valid_radius(self) -> float:
        """The distorted radius, in px, up to which the map is positive and monotonic (inf if everywhere).

        The denominator must stay above 0, and so must the derivative's numerator
        1 - lam r^2 - 3 lam2 r^4.
        """
        bounds = [_first_root(self.lam, self.lam2), _first_root(-self.lam, -3 * self.lam2)]
        return math.sqrt(min(bounds))

    def undistort(self, points: ArrayLike) -> Points:
        """Map distorted points, (..., 2) px, to undistorted ones of the same shape (eq. 4).

        Points at or beyond ``valid_radius`` come back as NaN.
        """
        d, q = self._offsets(points)
        denominator = self.denominator(q)
        with np.errstate(divide="ignore", invalid="ignore"):
            out = d / denominator[..., None] + self.center
        out[q >= self.valid_radius**2] = np.nan
        return out

    def distort(self, points: ArrayLike) -> Points:
        """Map undistorted points, (..., 2) px, to distorted ones: the inverse of ``undistort``.

        Closed form for the one-parameter model, safeguarded Newton steps for the two-parameter one.
        Points that no distorted point maps to come back as NaN.
        """
        d, q = self._offsets(points)
        return d * self.radial_ratio(q)[..., None] + self.center

    def denominator(self, q: NDArray[np.floating]) -> NDArray[np.floating]:
        """r_d / r_u for squared distorted radii ``q`` in px^2, also where the map does not hold."""
        return 1 + q * (self.lam + q * self.lam2)

    def radial_ratio(self, squared_radius: NDArray[np.float64]) -> NDArray[np.float64]:
        """r_d / r_u for squared undistorted radii in px^2; NaN where no distorted radius exists."""
        q = np.asarray(squared_radius, np.float64)
        if self.lam2 == 0:
            with np.errstate(invalid="ignore"):
                return 2 / (1 + np.sqrt(1 - 4 * self.lam * q))
        return _invert_radius(np.sqrt(q), self.lam, self.lam2, self.valid_radius)

    def jacobian(self, points: ArrayLike) -> NDArray[np.float64]:
        """The derivative of ``undistort`` at distorted points (..., 2): arrays (..., 2, 2), d x_u / d x_d."""
        d, q = self._offsets(points)
        den = (1 + q * (self.lam + q * self.lam2))[..., None, None]
        slope = 2 * (self.lam + 2 * q * self.lam2)[..., None]
        metric = np.array([self.pixel_aspect**2, 1.0])
        outer = d[..., :, None] * (slope * d * metric)[..., None, :]
        return np.eye(2) / den - outer / den**2

    def undistorted_gradient(self, points: ArrayLike, gradients: ArrayLike) -> NDArray[np.float64]:
        """The unit image gradient at the undistorted place of an edge point (eq. 7).

        ``points`` (..., 2) are distorted, in px; ``gradients`` (..., 2) are there, of any length. The
        tangent of the edge is pushed through the Jacobian and turned back by 90 degrees.
        """
        g = np.asarray(gradients, np.float64)
        tangent = np.stack([-g[..., 1], g[..., 0]], axis=-1)
        pushed = np.einsum("...ij,...j->...i", self.jacobian(points), tangent)
        normal = np.stack([pushed[..., 1], -pushed[..., 0]], axis=-1)
        return normal / np.linalg.norm(normal, axis=-1, keepdims=True)

    def rescale(self, size: tuple[int, int]) -> DivisionModel:
        """Return the model for the same picture at another frame size.

        lam scales with 1/s^2 (lam2 with 1/s^4) and the centre by pixel centres. Raises InputError for
        another aspect ratio.
        """
        if tuple(size) == self.size:
            return self
        sx, sy = size[0] / self.size[0], size[1] / self.size[1]
        if abs(sx / sy - 1) > _ASPECT_TOLERANCE:
            raise InputError(
                f"a calibration for {self.size[0]}x{self.size[1]} does not fit a frame of"
                f" {size[0]}x{size[1]}: another aspect ratio"
            )
        return replace(
            self,
            lam=self.lam / sy**2,
            lam2=self.lam2 / sy**4,
            center=rescaled_place(self.center, (sx, sy)),
            size=(int(size[0]), int(size[1])),
        )

    def _offsets(self, points: ArrayLike) -> tuple[Points, NDArray[np.float64]]:
        """Offsets from the centre, px, and their squared lengths in square pixels."""
        d = np.asarray(points, np.float64) - self.center
        return d, (d[..., 0] * self.pixel_aspect) ** 2 + d[..., 1] ** 2


def _are_finite(values: Any, count: int) -> bool:
    try:
        return len(values) == count and all(math.isfinite(v) for v in values)
    except (TypeError, OverflowError):
        return False


def _first_root(a: float, b: float) -> float:
    """Find the smallest q > 0 with 1 + a q + b q^2 = 0, or inf."""
    if b == 0:
        return -1 / a if a < 0 else math.inf
    discriminant = a * a - 4 * b
    if discriminant < 0:
        return math.inf
    # The stable pair of roots in 1/q, of p^2 + a p + b = 0; the largest positive 1/q is the first q.
    s = -(a + math.copysign(math.sqrt(discriminant), a)) / 2
    largest = max(s, b / s if s else 0.0)
    return 1 / largest if largest > 0 else math.inf


def _invert_radius(
    ru: NDArray[np.float64], lam: float, lam2: float, limit: float
) -> NDArray[np.float64]:
    """r_d / r_u where r_u = r_d / (1 + lam r_d^2 + lam2 r_d^4), for r_d below ``limit``; NaN beyond."""
    low = np.zeros_like(ru)
    high = np.full_like(ru, limit) if math.isfinite(limit) else np.maximum(ru, 1.0) * 1e3
    rd = np.minimum(ru, high * 0.5)
    for _ in range(60):
        q = rd * rd
        value = ru * (1 + q * (lam + q * lam2)) - rd
        low, high = np.where(value > 0, rd, low), np.where(value > 0, high, rd)
        slope = ru * rd * (2 * lam + 4 * q * lam2) - 1
        with np.errstate(divide="ignore", invalid="ignore"):
            step = rd - value / slope
        # A step that rounding ends on the bound itself has arrived.
        inside = (step >= low) & (step <= high)
        nearer = np.where(inside, step, (low + high) / 2)
        if np.all(np.abs(nearer - rd) <= 1e-13 * np.maximum(rd, 1)):
            rd = nearer
            break
        rd = nearer
    q = rd * rd
    with np.errstate(divide="ignore", invalid="ignore"):
        reached = np.abs(ru * (1 + q * (lam + q * lam2)) - rd) <= 1e-6 * np.maximum(rd, 1)
        ratio = np.where(ru > 0, rd / np.where(ru > 0, ru, 1), 1.0)
    return np.where(reached, ratio, np.nan)


def rescaled_place(place: tuple[float, float], scale: tuple[float, float]) -> tuple[float, float]:
    """Return where a place (x, y) px lies in the frame rescaled by ``scale`` (x, y), by pixel centres."""
    return (place[0] + 0.5) * scale[0] - 0.5, (place[1] + 0.5) * scale[1] - 0.5
