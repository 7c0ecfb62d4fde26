"""How surely a calibration places a point in the corrected picture."""

from __future__ import annotations

import numpy as np

from ..calibration.outcome import Workings
from ..calibration.straightness import Floats
from ..model import DivisionModel

# Steps of the parameters for numeric derivatives, in their standard deviations.
_STEP = 0.1


def parameters(model: DivisionModel) -> Floats:
    """Return (lam, cx, cy[, lam2]) in square pixels."""
    cx, cy = model.center
    second = [model.lam2] if model.lam2 else []
    return np.array([model.lam, cx * model.pixel_aspect, cy, *second])


def undistorted(points: Floats, params: Floats) -> Floats:
    """Undistort points (n, 2) by a parameter vector, all in square pixels; NaN past the fold."""
    lam2 = params[3] if len(params) > 3 else 0.0
    d = points - params[1:3]
    r2 = (d**2).sum(axis=1)
    scale = 1 + r2 * (params[0] + r2 * lam2)
    with np.errstate(divide="ignore"):
        return np.asarray(np.where(scale[:, None] > 0, params[1:3] + d / scale[:, None], np.nan))


def placing_sigma(workings: Workings, model: DivisionModel, points: Floats) -> Floats:
    """Return the standard deviation (n,), px, of where points (n, 2) of the picture are put.

    Of the two coordinates together, from the covariance of the parameters. Points in square pixels.
    """
    assert workings.covariance is not None
    params = parameters(model)
    covariance = workings.covariance[: len(params), : len(params)]
    sigmas = np.sqrt(np.maximum(np.diag(covariance), 0))
    slopes = np.zeros((len(points), 2, len(params)))
    for i, sigma in enumerate(sigmas):
        if sigma > 0:
            step = np.zeros(len(params))
            step[i] = _STEP * sigma
            ahead, behind = undistorted(points, params + step), undistorted(points, params - step)
            slopes[:, :, i] = (ahead - behind) / (2 * step[i])
    variance = np.einsum("nci,ij,ncj->n", slopes, covariance, slopes)
    return np.asarray(np.sqrt(np.maximum(variance, 0)))
