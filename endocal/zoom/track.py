"""The zoom from the picture itself, for when the circle's rim is out of the frame.

Points of the scene are followed from frame to frame. A zoom magnifies the distorted picture by one factor
about the distortion centre; a moving camera changes the undistorted picture, and that only by what a
rotation and a translation can do. Under a lens with real distortion the two differ: a camera that comes
nearer moves the middle more than the rim, a zoom moves both alike. A fit with both in it tells them apart,
as well as the lens and the scene allow, and says how well that was.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from ..model import DivisionModel
from .table import ZoomTable

Luma = NDArray[np.uint8]
Points = NDArray[np.float64]

_TUKEY = 4.685
_MAD_TO_SIGMA = 1.4826
_FIT_ROUNDS = 6
# Over this step of the logarithm the centre's movement is taken.
_AHEAD = 1e-3


@dataclass(frozen=True)
class TrackingSpec:
    """How the zoom is tracked.

    The picture is reduced to about ``height`` px, and up to ``points`` places are followed in it, ``spacing``
    reduced px apart and not nearer to the rim than at ``reach`` of the circle's radius. With fewer than
    ``least`` the step is given up; new ones are sought below ``renew`` of those that were found. ``zoom``
    and ``approach`` are what to expect, before looking, of a zoom and of a camera that comes nearer: one
    standard deviation of the relative scale per frame. ``noise`` is the least error of a followed place,
    reduced px.
    """

    height: int = 360
    points: int = 200
    reach: float = 0.94
    least: int = 24
    renew: float = 0.8
    zoom: float = 0.02
    approach: float = 0.004
    noise: float = 0.05
    spacing: float = 18.0


class ScaleStep(NamedTuple):
    """The relative scale of the zoom between two frames, as a logarithm, and its standard deviation.

    ``approach`` is that part of the picture's dilation that was put down to the camera coming nearer.
    """

    logarithm: float
    sigma: float
    approach: float


class ScaleTracker:
    """Follows the scale of successive frames of one size."""

    def __init__(self, pixel_aspect: float = 1.0, spec: TrackingSpec = TrackingSpec()) -> None:
        self._aspect = pixel_aspect
        self._spec = spec
        self._last: Luma | None = None
        self._places = np.empty((0, 1, 2), np.float32)
        self._sought = 0

    def forget(self) -> None:
        """Begin anew with the next frame."""
        self._last = None

    def step(
        self, luma: NDArray[np.uint8] | NDArray[np.uint16], table: ZoomTable, diameter: float
    ) -> ScaleStep | None:
        """Return the scale from the last frame to this one; None where it cannot be told.

        ``diameter`` (px) is that of the last frame, which the ``table`` has the model for.
        """
        model = table.at_diameter(diameter)
        reduction = max(1, round(luma.shape[0] / self._spec.height))
        current = _reduced(luma, reduction)
        last, self._last = self._last, current
        if last is None or last.shape != current.shape:
            self._places, self._sought = self._places[:0], 0
            return None
        if len(self._places) <= self._spec.renew * self._sought:
            self._places = self._seek(last, reduction, model, diameter)
            self._sought = len(self._places)
        if len(self._places) < self._spec.least:
            return None
        moved, found = _follow(last, current, self._places)
        before, after = self._places[found][:, 0], moved[found][:, 0]
        self._places = moved[found]
        if len(after) < self._spec.least:
            return None
        return scale_between(
            self._offsets(before, reduction, model),
            self._offsets(after, reduction, model),
            model,
            diameter,
            self._drift(table, model, diameter),
            self._spec,
            self._spec.noise * reduction,
        )

    def _drift(
        self, table: ZoomTable, model: DivisionModel, diameter: float
    ) -> tuple[float, float]:
        """Return how the distortion centre moves with the logarithm of the diameter, px of the height."""
        ahead = table.at_diameter(diameter * math.exp(_AHEAD)).center
        x, y = ((a - b) / _AHEAD for a, b in zip(ahead, model.center, strict=True))
        return x * self._aspect, y

    def _seek(
        self, image: Luma, reduction: int, model: DivisionModel, diameter: float
    ) -> NDArray[np.float32]:
        """Find places that can be followed, away from the rim; (n, 1, 2) reduced px."""
        spec = self._spec
        corners = cv2.goodFeaturesToTrack(image, spec.points, 0.005, spec.spacing, blockSize=5)
        if corners is None:
            return np.empty((0, 1, 2), np.float32)
        places: NDArray[np.float32] = np.asarray(corners, np.float32)
        offset = self._offsets(places[:, 0], reduction, model)
        return places[np.hypot(offset[:, 0], offset[:, 1]) < spec.reach * diameter / 2]

    def _offsets(self, places: NDArray[np.float32], reduction: int, model: DivisionModel) -> Points:
        """Turn reduced px into offsets from the distortion centre, in px of the height."""
        full = (places.astype(np.float64) + 0.5) * reduction - 0.5 - model.center
        full[:, 0] *= self._aspect
        return full


def scale_between(
    before: Points,
    after: Points,
    model: DivisionModel,
    diameter: float,
    drift: tuple[float, float] = (0.0, 0.0),
    spec: TrackingSpec = TrackingSpec(),
    noise: float = 0.1,
) -> ScaleStep:
    """Fit the relative scale between matched places and the camera's motion together.

    ``before`` and ``after`` are (n, 2) offsets from the distortion centre, px; the ``model`` is that of the
    first frame, at ``diameter`` px, and ``drift`` how its centre moves with the logarithm of the diameter,
    px; ``noise`` is the least error of a place, px. The camera's motion is that of the undistorted picture
    of a plane: eight parameters, of which the dilation is expected to be small.
    """
    strength, strength2 = model.lam * diameter**2, model.lam2 * diameter**4
    start, _ = _undistorted(before / diameter, strength, strength2)
    end, stretch = _undistorted(after / diameter, strength, strength2)
    # Residuals count in distorted px, where the places were measured.
    back = diameter * np.linalg.inv(stretch)
    zoomed = (after + drift)[:, :, None]
    design = np.concatenate([back @ _camera_motion(start), zoomed], axis=2)
    shift = np.einsum("nij,nj->ni", back, end - start)
    expected = np.full(design.shape[2], np.inf)
    expected[_DILATION], expected[-1] = spec.approach, spec.zoom
    weight = np.ones(len(before))
    scale = math.inf
    solution, covariance = np.zeros(design.shape[2]), np.zeros((design.shape[2],) * 2)
    for _ in range(_FIT_ROUNDS):
        prior = np.diag((min(scale, 1e3) / expected) ** 2)
        weighted = design * weight[:, None, None]
        normal = np.einsum("nij,nik->jk", weighted, design) + prior
        covariance = np.linalg.pinv(normal)
        solution = covariance @ np.einsum("nij,ni->j", weighted, shift)
        residual = np.linalg.norm(shift - design @ solution, axis=1)
        # The median of a two-dimensional normal residual's length is 1.1774 standard deviations.
        scale = max(float(np.median(residual)) / 1.1774, noise)
        weight = np.maximum(1 - (residual / (_TUKEY * scale)) ** 2, 0) ** 2
    # What was fitted is the part of the later offset that the zoom made: 1 - exp(-logarithm).
    return ScaleStep(
        -math.log1p(-float(solution[-1])),
        scale * math.sqrt(max(covariance[-1, -1], 0.0)),
        float(solution[_DILATION]),
    )


_DILATION = 3


def _camera_motion(u: Points) -> NDArray[np.float64]:
    """The undistorted flow before a moving camera (Longuet-Higgins and Prazdny 1980): (n, 2, 10).

    Of a plane: shift in x and y, rotation, dilation, two shears, and the two perspective terms. With the
    last two, of a wall that curves as well, as far as it moves sideways.
    """
    x, y = u[:, 0], u[:, 1]
    one, zero = np.ones_like(x), np.zeros_like(x)
    rows = (
        (one, zero, -y, x, x, y, x * x, x * y, y * y, zero),
        (zero, one, x, y, -y, x, x * y, y * y, zero, x * x),
    )
    return np.stack([np.stack(row, axis=1) for row in rows], axis=1)


def _undistorted(
    n: Points, strength: float, strength2: float
) -> tuple[Points, NDArray[np.float64]]:
    """Undistort offsets in units of the diameter: (n, 2), and the derivative there, (n, 2, 2)."""
    q = (n * n).sum(axis=1)
    denominator = 1 + q * (strength + q * strength2)
    slope = 2 * (strength + 2 * q * strength2)
    outer = n[:, :, None] * n[:, None, :] * (slope / denominator**2)[:, None, None]
    return n / denominator[:, None], np.eye(2) / denominator[:, None, None] - outer


def _reduced(luma: NDArray[np.uint8] | NDArray[np.uint16], reduction: int) -> Luma:
    """Average the picture over blocks of ``reduction`` px, in 8 bit."""
    size = (luma.shape[1] // reduction, luma.shape[0] // reduction)
    small = np.asarray(cv2.resize(luma, size, interpolation=cv2.INTER_AREA), luma.dtype)
    depth = max(int(small.max()).bit_length() - 8, 0) if small.dtype != np.uint8 else 0
    return (small // (1 << depth)).astype(np.uint8) if depth else np.asarray(small, np.uint8)


def _follow(
    last: Luma, current: Luma, places: NDArray[np.float32]
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Follow places by Lucas and Kanade's method, there and back; those that do not come back are lost."""
    settings: dict[str, Any] = {
        "winSize": (17, 17),
        "maxLevel": 3,
        "criteria": (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 15, 0.02),
    }
    # OpenCV takes None for places that it is to make room for, whatever its annotations say.
    empty: Any = None
    moved, there, _ = cv2.calcOpticalFlowPyrLK(last, current, places, empty, **settings)
    returned, back, _ = cv2.calcOpticalFlowPyrLK(current, last, moved, empty, **settings)
    apart = np.linalg.norm(returned - places, axis=(1, 2))
    found = (there[:, 0] > 0) & (back[:, 0] > 0) & (apart < 0.3)
    return np.asarray(moved, np.float32), found
