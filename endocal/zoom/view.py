"""Places of a reduced picture, as the lens shows them at one zoom, and as they were without distortion."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model import DivisionModel
from .shift import Offset, shifted
from .table import ZoomTable

Points = NDArray[np.float64]

# lam f^2 of a usual lens, without its sign: where angles map to radii evenly it is 1/3,
# and real ones lie around.
USUAL_FOCAL = 0.36
# Over this step of the logarithm the centre's movement is taken.
_AHEAD = 1e-3

# No lens is taken to be straighter than this, as lam D^2, when its focal length is guessed.
_STRAIGHTEST = 0.1


@dataclass(frozen=True)
class View:
    """A picture reduced ``reduction`` times, by a lens whose circle is ``diameter`` px wide: its ``model``.

    Offsets are from the distortion centre, in px of the full height; undistorted places are in units of the
    diameter, so that a zoom alone leaves those of the scene where they are.
    """

    model: DivisionModel
    diameter: float
    reduction: int

    @property
    def strengths(self) -> tuple[float, float]:
        """The distortion in units of the diameter: lam D^2 and lam2 D^4."""
        return self.model.lam * self.diameter**2, self.model.lam2 * self.diameter**4

    def offsets(self, places: NDArray[np.floating]) -> Points:
        """Turn reduced px (n, 2) into offsets, px."""
        full = (np.asarray(places, np.float64) + 0.5) * self.reduction - 0.5 - self.model.center
        full[:, 0] *= self.model.pixel_aspect
        return full

    def undistorted(self, places: NDArray[np.floating]) -> Points:
        """Undistort reduced px (n, 2)."""
        return undistorted(self.offsets(places) / self.diameter, *self.strengths)[0]

    def places(self, scene: Points) -> Points:
        """Turn undistorted places (n, 2) into reduced px; NaN where the lens shows none."""
        away = scene * self.diameter
        full = away * self.model.radial_ratio((away**2).sum(axis=1))[:, None]
        full[:, 0] /= self.model.pixel_aspect
        return np.asarray((full + self.model.center + 0.5) / self.reduction - 0.5, np.float64)


def view_at(table: ZoomTable, diameter: float, shift: Offset, reduction: int) -> View:
    """Return how a picture is seen where the circle is ``diameter`` px wide, and ``shift`` (x, y) px off."""
    return View(shifted(table.at_diameter(diameter), shift), diameter, reduction)


def center_drift(table: ZoomTable, diameter: float) -> Offset:
    """Return how the distortion centre moves with the logarithm of the diameter, px of the height."""
    here = table.at_diameter(diameter).center
    ahead = table.at_diameter(diameter * math.exp(_AHEAD)).center
    x, y = ((a - b) / _AHEAD for a, b in zip(ahead, here, strict=True))
    return x * table.pixel_aspect, y


def guessed_focal(strength: float, strength2: float, usual: float) -> float:
    """Return the focal length, in units of the diameter, of a lens whose lam f^2 is the ``usual``."""
    return math.sqrt(usual / max(abs(strength + strength2 / 4), _STRAIGHTEST))


def undistorted(n: Points, strength: float, strength2: float) -> tuple[Points, Points]:
    """Undistort offsets in units of the diameter: (n, 2), and the derivative there, (n, 2, 2)."""
    q = (n * n).sum(axis=1)
    denominator = 1 + q * (strength + q * strength2)
    slope = 2 * (strength + 2 * q * strength2)
    outer = n[:, :, None] * n[:, None, :] * (slope / denominator**2)[:, None, None]
    return n / denominator[:, None], np.eye(2) / denominator[:, None, None] - outer
