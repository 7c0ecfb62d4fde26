"""The zoom between two pictures far apart, by the lens alone.

Before a plane, and for a camera that turns before any scene, what two pictures show without distortion is
related by a homography, however far apart they are and whatever the focal length. A zoom magnifies the
distorted picture instead. So the homography takes in all that the camera did, and what the lens's distortion
adds to it tells the zoom.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .likeness import Likeness, part_of
from .robust import biweight, spread
from .view import Points, View, undistorted

_FIT_ROUNDS = 4
# Columns of the design: aside along x and y, roll, two stretches, two tilts; approach; zoom.
_APPROACH, _ZOOM = 7, 8


@dataclass(frozen=True)
class PlanarSpec:
    """What is expected of a homography and of its errors.

    Each of its coefficients changes by ``wide`` (one standard deviation, in units of the diameter), but for
    the approach. The zoom is within ``zoom`` (relative) of where it is taken to be. What no plane explains is
    shared by neighbours, so that all places together count as ``patches`` in this respect, in full where
    their residuals correlate by ``alike``, averaged over ``remembered`` fits or so.
    """

    wide: float = 1.0
    zoom: float = 0.2
    patches: float = 4.0
    alike: float = 0.1
    remembered: float = 6.0


class PlanarMotion(NamedTuple):
    """What became of a picture: a ``homography`` of undistorted places, and a zoom by a ``logarithm``."""

    homography: NDArray[np.float64] = np.eye(3)
    logarithm: float = 0.0

    @property
    def approach(self) -> float:
        """How much nearer the camera came, as a logarithm: the homography's scale at the centre."""
        h = self.homography / self.homography[2, 2]
        return math.log(abs(float(np.linalg.det(h[:2, :2] - np.outer(h[:2, 2], h[2, :2]))))) / 2

    @property
    def aside(self) -> float:
        """How far the middle of the picture went, in units of the diameter."""
        return math.hypot(*self.homography[:2, 2])

    @property
    def scale(self) -> float:
        """By how much the picture's middle is magnified."""
        return math.exp(self.approach + self.logarithm)

    def then(self, generator: NDArray[np.float64], logarithm: float) -> PlanarMotion:
        """Return this motion and a small one after it."""
        half = generator / 2
        # The flow counts between the two places, as it was fitted.
        step = np.linalg.solve(np.eye(3) - half, np.eye(3) + half)
        return PlanarMotion(_normal(step @ self.homography), self.logarithm + logarithm)

    def forth(self, scene: Points) -> Points:
        """Move undistorted places (n, 2) from the first picture to the second."""
        return _mapped(self.homography, scene)

    def back(self, scene: Points) -> Points:
        """Move undistorted places (n, 2) from the second picture to the first."""
        return _mapped(np.asarray(np.linalg.inv(self.homography), np.float64), scene)


class PlanarFit(NamedTuple):
    """A motion, one standard deviation of its zoom's logarithm, and the part of errors that is shared."""

    motion: PlanarMotion
    sigma: float
    shared: float


def fit_planar(
    start: Points,
    places: NDArray[np.float32],
    view: View,
    drift: tuple[float, float],
    motion: PlanarMotion,
    hand: float,
    noise: float,
    likeness: Likeness,
    spec: PlanarSpec = PlanarSpec(),
) -> PlanarFit:
    """Fit the motion that took undistorted places ``start`` (n, 2) to ``places`` (n, 2) reduced px.

    ``view`` is how the later picture is seen if the zoom of ``motion`` is right, from which the search
    starts, and ``drift`` how its centre moves with the logarithm of the diameter, px. ``hand`` is by how much
    the camera may have come nearer, one standard deviation of a logarithm, and ``noise`` the least error of a
    place, px. Tukey's biweight keeps out what moves on its own.
    """
    after, strengths = view.offsets(places), view.strengths
    begun = motion.logarithm
    weight, scale = np.ones(len(start)), 0.0
    expected = np.array([spec.wide] * _APPROACH + [hand, spec.zoom]) ** -2.0
    for _ in range(_FIT_ROUNDS):
        zoom = motion.logarithm - begun
        late, zoomed = after - np.multiply(drift, zoom), view.diameter * math.exp(zoom)
        end, stretch = undistorted(late / zoomed, *strengths)
        here = motion.forth(start)
        # Residuals count in distorted px, where the places were measured.
        back = zoomed * np.linalg.inv(stretch)
        shift = (back @ (end - here)[..., None])[..., 0]
        # Where places are expected, not where they were measured: else their noise would tell a zoom from
        # an approach.
        magnified = late - shift + drift
        design = np.concatenate([back @ _camera(here), magnified[..., None]], axis=2)
        if not scale:
            # Where the search starts is nearly right: what is far off, an instrument, is no part of it.
            scale = max(spread(shift), noise)
            weight = biweight(shift, scale)
        weighted = design * (weight / scale**2)[:, None, None]
        normal = np.tensordot(weighted, design, axes=((0, 1), (0, 1))) + np.diag(expected)
        target = np.tensordot(weighted, shift, axes=((0, 1), (0, 1)))
        target[_APPROACH] -= expected[_APPROACH] * motion.approach
        target[_ZOOM] -= expected[_ZOOM] * zoom
        found = np.linalg.solve(normal, target)
        residual = shift - design @ found
        motion = PlanarMotion(
            _normal((np.eye(3) + _generator(found)) @ motion.homography),
            motion.logarithm + float(np.clip(found[_ZOOM], -spec.zoom, spec.zoom)),
        )
        scale = max(spread(residual), noise)
        weight = biweight(residual, scale)
    likeness.learn(after, residual, weight)
    crowd = max(float(weight.sum()) / spec.patches, 1.0)
    part = part_of(likeness.alike, spec.alike)
    # What a place's own error is not, neighbours share.
    more = (noise**2 + (scale**2 - noise**2) * (1 + part * (crowd - 1))) / scale**2
    variance = float(np.linalg.inv(normal)[_ZOOM, _ZOOM]) * more
    return PlanarFit(motion, math.sqrt(variance), part)


def _camera(scene: Points) -> Points:
    """Return how undistorted places (n, 2) move as the coefficients of a homography change: (n, 2, 8)."""
    x, y = scene.T
    none, one = np.zeros_like(x), np.ones_like(x)
    along_x = [one, none, -y, x, y, x * x, x * y, x]
    along_y = [none, one, x, -y, x, x * y, y * y, y]
    return np.stack([np.stack(along_x, axis=1), np.stack(along_y, axis=1)], axis=1)


def _generator(change: Points) -> Points:
    """Return the (3, 3) matrix of such changes, (8,) or more."""
    across, down, roll, stretch, skew, tilt_x, tilt_y, approach = change[:8]
    return np.array(
        [
            [stretch + approach, skew - roll, across],
            [skew + roll, approach - stretch, down],
            [-tilt_x, -tilt_y, 0.0],
        ]
    )


def _mapped(homography: NDArray[np.float64], scene: Points) -> Points:
    moved = scene @ homography[:, :2].T + homography[:, 2]
    return np.asarray(moved[:, :2] / moved[:, 2:], np.float64)


def _normal(homography: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(homography / homography[2, 2], np.float64)
