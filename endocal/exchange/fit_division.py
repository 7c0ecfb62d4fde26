"""From OpenCV's models to the division model that corrects most alike."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from ..errors import InputError
from ..model import DivisionModel, Points
from .camera import Camera

# Two focal lengths nearer than this (relative) are those of square pixels, measured: the rarest pixels in
# use that are not square (59:54, 16:15) differ by more.
_SQUARE = 0.03
# Directions around the principal point, steps along each in search of the content's end, radii compared.
_DIRECTIONS, _STEPS, _RADII = 72, 1024, 32
# Rays farther than this from the axis have no place in a plane picture.
_STEEPEST = math.radians(88)
_FAR = 1e3  # px: the residual of a point that the model cannot reach

Array = NDArray[np.float64]


@dataclass(frozen=True)
class DivisionFit:
    """A division model, and how far it is from the camera over the content, in distorted px.

    ``reach`` is None, or the distance in px from the centre up to which the camera's own model is
    one-to-one, where that ends inside the content.
    """

    model: DivisionModel
    largest: float
    rms: float
    reach: float | None


def fit_division(camera: Camera, two_parameters: bool = False) -> DivisionFit:
    """Fit lambda and the centre (and lambda2) by least squares over the frame, or the visible circle in it.

    The corrected pictures are compared as straight lines see them: either may be shifted and stretched along
    its axes against the other. Raises InputError where the camera maps nothing into the frame.
    """
    aspect = camera.focal[1] / camera.focal[0]
    aspect = 1.0 if abs(aspect - 1) < _SQUARE else aspect
    rays, folded = _content_rays(camera, aspect)
    rays = rays.reshape(-1, 2)
    undistorted, distorted = camera.undistorted(rays), camera.distorted(rays)
    metric = np.array([aspect, 1.0])
    unit = float(np.abs((distorted - camera.center) * metric).max())
    du, dd = (np.hypot(*((p - camera.center) * metric).T) for p in (undistorted, distorted))
    # r_d - r_u = lambda r_u r_d^2, with equal areas of the distorted picture counting alike.
    slope, weight = du * dd**2, np.sqrt(np.maximum(dd, 1e-9) / unit)
    lam = float(((dd - du) * slope).sum() / max((slope**2).sum(), 1e-300))

    def model_of(p: Array) -> DivisionModel:
        return DivisionModel(
            p[0] / unit**2,
            (camera.center[0] + p[1] * unit, camera.center[1] + p[2] * unit),
            camera.size,
            aspect,
            p[7] / unit**4 if two_parameters else 0.0,
        )

    def errors(p: Array) -> Points:
        model = model_of(p)
        moved = (undistorted - model.center) * (1 + p[3:5]) + model.center + p[5:7] * unit
        gap = (model.distort(moved) - distorted) * metric
        return np.where(np.isfinite(gap), gap, _FAR)

    start = np.zeros(8 if two_parameters else 7)
    start[0] = lam * unit**2
    # A centre outside the frame is none; the rest is free.
    bounds = np.full((2, len(start)), [[-np.inf], [np.inf]])
    for i in (0, 1):
        ends = (np.array([-0.5, 1.5]) * camera.size[i] - camera.center[i]) / unit
        bounds[:, 1 + i] = ends
    fit = least_squares(
        lambda p: (errors(p) * weight[:, None]).ravel(), start, bounds=bounds, x_scale="jac"
    )
    gap = np.hypot(*errors(fit.x).T)
    model = model_of(fit.x)
    reach = None
    if folded.any():
        ends = distorted.reshape(len(folded), -1, 2)[folded, -1]
        reach = float(np.hypot(*((ends - model.center) * metric).T).min())
    rms = math.sqrt(float(np.average(gap**2, weights=weight**2)))
    return DivisionFit(model, float(gap.max()), rms, reach)


def _content_rays(camera: Camera, aspect: float) -> tuple[Points, NDArray[np.bool_]]:
    """Rays (directions, radii, 2) that fill the content, and where the map folds before the content ends."""
    angle = np.linspace(0, 2 * np.pi, _DIRECTIONS, endpoint=False)
    directions = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    lengths = np.tan(np.linspace(0, _STEEPEST, _STEPS))
    rays = lengths[None, :, None] * directions[:, None]
    points = camera.distorted(rays.reshape(-1, 2)).reshape(rays.shape)
    radius = np.hypot(*np.moveaxis((points - camera.center) * [aspect, 1.0], -1, 0))
    (w, h), (x, y) = camera.size, np.moveaxis(points, -1, 0)
    inside = (x >= 0) & (x <= w - 1) & (y >= 0) & (y <= h - 1)
    if camera.circle is not None:
        off = (points - camera.circle[:2]) * [aspect, 1.0]
        inside &= np.hypot(*np.moveaxis(off, -1, 0)) <= camera.circle[2] / 2
    growing = np.concatenate([np.ones((_DIRECTIONS, 1), bool), np.diff(radius, axis=1) > 0], axis=1)
    sound = np.logical_and.accumulate(inside & growing, axis=1)
    last = sound.sum(axis=1) - 1
    if (last < 1).mean() > 0.5:
        raise InputError("the camera's principal point lies outside the content")
    after = np.minimum(last + 1, _STEPS - 1)
    rows = np.arange(_DIRECTIONS)
    folded = inside[rows, after]
    share = np.arange(1, _RADII + 1) / _RADII
    # Even steps in the angle: the rim, where the rays spread, is not sampled thinner than the middle.
    ends = np.arctan(lengths[np.maximum(last, 0)])
    even = np.tan(ends[:, None] * share)
    found = last > 0
    return (even[..., None] * directions[:, None])[found], folded[found]
