"""The directions from which the pixels of a distorted picture get their light."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model import DivisionModel
from .fisheye import Fisheye
from .sampling import Coordinates


@dataclass(frozen=True)
class Rays:
    """Where each pixel looks: float32 arrays (h, w), in units of the focal length.

    (``x``, ``y``, 1) points from the lens along the ray; NaN where the model sees nothing. ``footprint`` is
    how far neighbouring pixels lie apart there (the geometric mean over the directions).
    """

    x: NDArray[np.float32]
    y: NDArray[np.float32]
    footprint: NDArray[np.float32]


def pixel_rays(model: DivisionModel, focal: float, margin: int = 0) -> Rays:
    """Return the rays of all pixels, of a frame that is ``margin`` px wider on each side.

    ``focal`` is the focal length of the undistorted picture, in px of the frame's height.
    """
    w, h = model.size
    x = np.arange(-margin, w + margin, dtype=np.float32)[None, :]
    y = np.arange(-margin, h + margin, dtype=np.float32)[:, None]
    dx, dy = (x - model.center[0]) * (model.pixel_aspect / focal), (y - model.center[1]) / focal
    lam, lam2 = model.lam * focal**2, model.lam2 * focal**4
    q = dx * dx + dy * dy
    valid = q < (model.valid_radius / focal) ** 2
    # Derivatives of the map along the radius and across it; their product is the stretch of an area.
    denominator = 1 + q * (lam + q * lam2)
    # A valid pixel next to the pole may round to it.
    across = 1 / np.where(valid & (denominator > 0), denominator, np.float32(np.nan))
    along = (1 - q * (lam + 3 * q * lam2)) * across * across
    footprint = np.sqrt(along * across) / focal
    return Rays(*(np.asarray(v, np.float32) for v in (dx * across, dy * across, footprint)))


def offsets(
    model: DivisionModel | Fisheye, x: Coordinates, y: Coordinates
) -> tuple[Coordinates, Coordinates]:
    """Undistorted offsets of points from the centre, in square px; NaN beyond the valid radius.

    What ``DivisionModel.undistort`` does, on separate coordinates and in the precision that they have.
    """
    dx, dy = (x - model.center[0]) * model.pixel_aspect, y - model.center[1]
    q = dx * dx + dy * dy
    with np.errstate(divide="ignore"):
        scale = 1 / model.denominator(q)
    scale[q >= model.valid_radius**2] = np.nan
    return dx * scale, dy * scale
