"""From a division model to OpenCV's: k1 k2 p1 p2 k3, or with k4 k5 k6 the rational one.

With r = r_u / f, f the focal length, OpenCV has r_d = r_u (1 + k1 r^2 + k2 r^4 + k3 r^6) over
(1 + k4 r^2 + k5 r^4 + k6 r^6). The division model is radial about its centre, so the principal point is
that centre and the tangential p1 and p2 are exactly 0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares, linprog

from ..errors import InputError
from ..model import DivisionModel
from .camera import Camera

# Radii at which the models are compared: steps far below the wavelength of what a polynomial misses.
_RADII = 512
# Digits of what is written; the fit itself is far coarser.
_DIGITS = 12

Array = NDArray[np.float64]


@dataclass(frozen=True)
class CameraFit:
    """A camera, and how far it is from the division model over the content, in distorted px."""

    camera: Camera
    largest: float
    rms: float


def fit_camera(
    model: DivisionModel, radius: float, rational: bool = False, focal: float | None = None
) -> CameraFit:
    """Fit OpenCV's model over the content within ``radius`` px of the centre.

    The polynomial has the least largest error, the rational model the least squares, each radius counting by
    its circumference. One picture does not tell the focal length, and any will do
    for correcting: ``focal`` px (of the frame's height) is taken as it is, and None takes the farthest
    content's undistorted radius, with which the coefficients are well conditioned. Raises InputError where
    the model folds within ``radius``.
    """
    rd = np.linspace(0, min(radius, model.valid_radius), _RADII + 1)[1:]
    ru = model.undistort(np.column_stack([np.zeros_like(rd), rd]) + model.center)[:, 1]
    ru = ru - model.center[1]
    if not np.isfinite(ru).all():
        raise InputError(f"the model folds within its content, {radius:.1f} px from the centre")
    reach = float(ru[-1])
    numerator, denominator = np.zeros(3), np.zeros(3)
    if rational and (model.lam or model.lam2):
        numerator, denominator = _rational(ru / reach, rd, ru)
    elif not rational:
        numerator = _polynomial(ru / reach, rd, ru)
    error = np.abs(_distorted(ru / reach, ru, numerator, denominator) - rd)
    f = reach if focal is None else focal
    if not (math.isfinite(f) and f > 0):
        raise InputError(f"the focal length {f:g} px is not a positive number")
    powers = (f / reach) ** np.array([2, 4, 6])
    (k1, k2, k3), (k4, k5, k6) = numerator * powers, denominator * powers
    coefficients = (k1, k2, 0.0, 0.0, k3, *((k4, k5, k6) if rational else ()))
    camera = Camera(
        focal=(_rounded(f / model.pixel_aspect), _rounded(f)),
        center=(_rounded(model.center[0]), _rounded(model.center[1])),
        coefficients=tuple(_rounded(k) for k in coefficients),
        size=model.size,
    )
    rms = math.sqrt(float(np.average(error**2, weights=rd)))
    return CameraFit(camera, float(error.max()), rms)


def _polynomial(t: Array, rd: Array, ru: Array) -> Array:
    """k1 k2 k3 of the least largest error, for radii in units of the farthest one: a linear program.

    Against least squares it halves the largest error and costs a twentieth of the root mean square.
    """
    terms = np.stack([ru * t**2, ru * t**4, ru * t**6], axis=1)
    bound = np.full((len(t), 1), -1.0)
    solution = linprog(
        [0, 0, 0, 1],
        A_ub=np.block([[terms, bound], [-terms, bound]]),
        b_ub=np.concatenate([rd - ru, ru - rd]),
        bounds=[(None, None)] * 3 + [(0, None)],
    )
    return np.asarray(solution.x[:3], np.float64)


def _rational(t: Array, rd: Array, ru: Array) -> tuple[Array, Array]:
    """k1 k2 k3 and k4 k5 k6 of the least squares."""
    weight = np.sqrt(rd / rd[-1])
    powers = np.stack([t**2, t**4, t**6], axis=1)
    # Multiplied by the denominator the problem is linear, and close enough to start from.
    terms = np.hstack([ru[:, None] * powers, -rd[:, None] * powers])
    start = np.linalg.lstsq(terms * weight[:, None], (rd - ru) * weight, rcond=None)[0]

    def residuals(k: Array) -> Array:
        return weight * (_distorted(t, ru, k[:3], k[3:]) - rd)

    accuracy = 1e-15
    fit = least_squares(
        residuals, start, x_scale="jac", xtol=accuracy, ftol=accuracy, gtol=accuracy, max_nfev=500
    )
    return fit.x[:3], fit.x[3:]


def _distorted(t: Array, ru: Array, numerator: Array, denominator: Array) -> Array:
    q = t * t
    up, down = (1 + q * (k[0] + q * (k[1] + q * k[2])) for k in (numerator, denominator))
    return ru * up / down


def _rounded(value: float) -> float:
    return float(f"{value:.{_DIGITS - 1}e}") + 0.0
