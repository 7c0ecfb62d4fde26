"""Telling a zoom from a camera that comes nearer, by the shape of the scene.

A zoom magnifies the distorted picture by one factor about the distortion centre. A camera that comes nearer
magnifies the undistorted picture, near things more than far ones: before a cavity, whose walls come nearer
towards the rim, that looks much like a zoom through a lens with distortion. But a hand also sways, and the
parallax of that shows how deep the scene is where. So the scene's shape is learned from frame to frame along
with the motion, and with it the two can be told apart, as well as lens and scene allow.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..model import DivisionModel
from .likeness import Likeness, part_of
from .robust import biweight, spread
from .view import USUAL_FOCAL, Points, guessed_focal, undistorted

_FIT_ROUNDS = 6
# Columns of the design: turn about y and x, roll; shift along x and y; approach; the shape's five; zoom.
_SHIFT, _APPROACH, _SHAPE, _ZOOM = slice(3, 5), 5, slice(6, 11), 11
# Of the shape's five, those of second order.
_BENDS = slice(2, 5)
_ALONG_AXIS = [_ZOOM, _APPROACH]


@dataclass(frozen=True)
class MotionSpec:
    """What is expected of the motion between two frames before looking: one standard deviation each.

    ``zoom`` is a relative scale, that of a ``resting`` zoom not quite none; ``approach`` and ``shift``,
    nearer and aside, are in distances to the scene; ``turn`` is in radians. ``shape`` is what is expected
    of each coefficient of the scene's relative inverse depth, a quadratic in tangents of angles, and
    ``reshaping`` of its change per frame. ``focal`` is lam f^2 of a usual lens, without its sign: where
    angles map to radii evenly it is 1/3, and real ones lie around. What no quadratic scene explains is
    shared by neighbouring places, so that all of them together count as ``patches`` in this respect. That
    counts in full where the residuals of neighbours correlate by ``alike``, and less where each is on its
    own, as it is where noise or a soft picture makes it: it is averaged over ``remembered`` steps or so. So
    it is with what neighbours have in common from one step to the next.

    An electronic zoom jumps, by 1.2 times or so. So where a zoom at rest leaves residuals of ``surprise``
    times the usual ones of the last ``lately`` steps or so, a zoom by ``jump`` is tried instead, and taken
    where it leaves less than the part ``explained`` of them. In the real laparoscopy, at rest, they are up
    to three times the usual, and no zoom halves them. A round of the fit changes the zoom by ``most``.
    """

    zoom: float = 0.02
    resting: float = 0.002
    approach: float = 0.003
    shift: float = 0.05
    turn: float = 0.05
    shape: float = 0.5
    reshaping: float = 0.001
    focal: float = USUAL_FOCAL
    patches: float = 12.0
    alike: float = 0.1
    remembered: float = 25.0
    surprise: float = 4.0
    lately: float = 10.0
    jump: float = 0.2
    explained: float = 0.5
    most: float = 0.1


class ScaleStep(NamedTuple):
    """The relative scale of the zoom between two frames, as a logarithm, and its standard deviation.

    ``approach`` is by how much the camera came nearer meanwhile, and ``aside`` (2,) by how much it went
    aside, in distances to the scene. Before anything is expected of zoom and approach, the picture says of
    them (``information``, (2, 2)) @ (zoom, approach) = ``target`` (2,), with the inverse of ``information``
    as their covariance. ``lasting`` is which part of their errors is the same in the steps that follow, from
    0 to 1, and ``curved`` by how much the scene's relative inverse depth is known to bend: the length of the
    quadratic's coefficients of second order. ``generator`` (3, 3) is how the camera's motion moved the
    undistorted places of a plane: the homography about halfway, less the identity.
    """

    logarithm: float
    sigma: float
    approach: float
    information: Points
    target: Points
    aside: Points
    lasting: float = 1.0
    curved: float = 0.0
    generator: Points = np.zeros((3, 3))


class _Pair(NamedTuple):
    """Places in two pictures and how the lens shows them: the arguments of ``SceneShape.scale_between``."""

    before: Points
    after: Points
    model: DivisionModel
    diameter: float
    drift: tuple[float, float]
    noise: float


class _Fit(NamedTuple):
    """A step, and what else came of its fit: the scene's shape, (5,), and its covariance.

    Besides the ``residual`` (n, 2) px of each place, its ``weight`` (n,), and the residuals' ``scale``, px.
    """

    step: ScaleStep
    shape: Points
    covariance: Points
    residual: Points
    weight: NDArray[np.float64]
    scale: float


class SceneShape:
    """The relative inverse depth of the scene over the field of view, learned while the motion is read."""

    def __init__(self, spec: MotionSpec = MotionSpec()) -> None:
        self._spec = spec
        self._shape = np.zeros(5)
        self._covariance = np.eye(5) * spec.shape**2
        self._likeness = Likeness(spec.remembered)
        # How far off places usually are, px.
        self._usual: float | None = None

    def scale_between(
        self,
        before: Points,
        after: Points,
        model: DivisionModel,
        diameter: float,
        drift: tuple[float, float] = (0.0, 0.0),
        noise: float = 0.1,
        rests: bool = False,
        hand: float | None = None,
    ) -> ScaleStep:
        """Fit the relative scale between matched places, the camera's motion and the shape together.

        ``before`` and ``after`` are (n, 2) offsets from the distortion centre, px; the ``model`` is that of
        the first frame, at ``diameter`` px, and ``drift`` how its centre moves with the logarithm of the
        diameter, px; ``noise`` is the least error of a place, px. The camera's motion is taken as small; the
        zoom need not be. Where it ``rests`` so far, the scene's shape is learned from the camera's motion
        alone. ``hand`` is how much nearer the camera is expected to come, in distances to the scene (one
        standard deviation); what the spec says without. Tukey's biweight keeps out what moves on its own.
        """
        spec = self._spec
        hand = spec.approach if hand is None else hand
        pair = _Pair(before, after, model, diameter, drift, noise)
        zoom = spec.resting if rests else spec.zoom
        fit = self._fit(pair, zoom, hand)
        if rests and fit.scale > spec.surprise * max(self._usual or 0.0, noise):
            # Something else than a hand before this scene, that a zoom at rest is no part of.
            jumped = self._fit(pair, spec.jump, hand)
            if jumped.scale < spec.explained * fit.scale:
                fit = jumped
        self._learn(before, fit)
        return fit.step._replace(
            lasting=part_of(self._likeness.lasting, spec.alike), curved=self._curved
        )

    def _learn(self, before: Points, fit: _Fit) -> None:
        """Take in what a step says of the scene's shape and of residuals."""
        self._shape, self._covariance = fit.shape, fit.covariance
        self._likeness.learn(before, fit.residual, fit.weight)
        usual = fit.scale if self._usual is None else self._usual
        # One that is far off is no measure of the others.
        self._usual = usual + (min(fit.scale, 2 * usual) - usual) / self._spec.lately

    def _fit(self, pair: _Pair, zoom: float, hand: float) -> _Fit:
        """Fit a step, where a zoom by ``zoom`` and an approach by ``hand`` are expected."""
        spec, (before, after, model, diameter, drift, noise) = self._spec, pair
        strength, strength2 = model.lam * diameter**2, model.lam2 * diameter**4
        focal = guessed_focal(strength, strength2, spec.focal)
        start, _ = undistorted(before / diameter, strength, strength2)
        known = self._known(zoom, hand)
        shape, motion, logarithm = self._shape, np.zeros(12), 0.0
        weight, scale = np.ones(len(before)), 0.0
        for _ in range(_FIT_ROUNDS):
            # The later picture, as far as the zoom is known; the rest of it is fitted.
            zoomed = diameter * math.exp(logarithm)
            late = after - np.multiply(drift, logarithm)
            end, stretch = undistorted(late / zoomed, strength, strength2)
            # Residuals count in distorted px, where the places were measured.
            back = zoomed * np.linalg.inv(stretch)
            shift = np.einsum("nij,nj->ni", back, end - start)
            flow = _camera_flow((start + end) / 2, focal, shape, motion)
            design = np.concatenate([back @ flow, (late + drift)[..., None]], axis=2)
            scale = max(scale or spread(shift), noise)
            # Noise is each place's own; of what is beyond it, neighbours share a rough scene's part.
            crowd = max(float(weight.sum()) / spec.patches, 1.0)
            shared = 1 + part_of(self._likeness.alike, spec.alike) * (crowd - 1)
            variance = noise**2 + (scale**2 - noise**2) * shared
            weighted = design * (weight / variance)[:, None, None]
            normal = np.einsum("nij,nik->jk", weighted, design) + known
            covariance = np.linalg.inv(normal)
            # What is known of shape and zoom counts from where they are now.
            target = np.einsum("nij,ni->j", weighted, shift)
            target[_SHAPE] += known[_SHAPE, _SHAPE] @ (self._shape - shape)
            target[_ZOOM] -= known[_ZOOM, _ZOOM] * logarithm
            motion = covariance @ target
            shape = shape + np.clip(motion[_SHAPE], -spec.shape, spec.shape)
            residual = shift - design @ motion
            logarithm += float(np.clip(motion[_ZOOM], -spec.most, spec.most))
            scale = max(spread(residual), noise)
            weight = biweight(residual, scale)
        deviation = math.sqrt(max(float(covariance[_ZOOM, _ZOOM]), 0.0))
        found = np.array([logarithm, motion[_APPROACH]])
        both = np.linalg.inv(covariance[np.ix_(_ALONG_AXIS, _ALONG_AXIS)])
        expected = np.diag(known[_ALONG_AXIS, _ALONG_AXIS])
        step = ScaleStep(
            logarithm,
            deviation,
            float(found[1]),
            both - expected,
            both @ found,
            motion[_SHIFT],
            generator=_generator(motion, shape, focal),
        )
        return _Fit(step, shape, covariance[_SHAPE, _SHAPE], residual, weight, scale)

    @property
    def _curved(self) -> float:
        """How much of the shape's second order is more than may be by chance."""
        square = float(
            (self._shape[_BENDS] ** 2).sum() - np.trace(self._covariance[_BENDS, _BENDS])
        )
        return math.sqrt(max(square, 0.0))

    def _known(self, zoom: float, hand: float) -> NDArray[np.float64]:
        """Return the inverse covariance of the parameters before looking: (12, 12)."""
        spec = self._spec
        sigma = np.array([spec.turn] * 3 + [spec.shift] * 2 + [hand] + [1.0] * 5 + [zoom])
        known = np.diag(sigma**-2.0)
        known[_SHAPE, _SHAPE] = np.linalg.inv(self._covariance + np.eye(5) * spec.reshaping**2)
        return known


def _camera_flow(
    places: Points, focal: float, shape: Points, motion: Points
) -> NDArray[np.float64]:
    """Return how the undistorted flow depends on all but the zoom, about this shape and motion: (n, 2, 11).

    ``places`` are (n, 2) in units of the diameter, as the flow. Longuet-Higgins and Prazdny (1980,
    doi:10.1098/rspb.1980.0057): a turn moves all depths alike, a translation by the inverse depth.
    """
    x, y = places.T / focal
    basis = np.stack([x, y, x * x, x * y, y * y], axis=1)
    near = 1 + basis @ shape
    out = np.zeros((len(places), 2, 11))
    out[:, 0, 0], out[:, 1, 0] = focal * (1 + x * x), focal * x * y
    out[:, 0, 1], out[:, 1, 1] = focal * x * y, focal * (1 + y * y)
    out[:, 0, 2], out[:, 1, 2] = -focal * y, focal * x
    out[:, 0, 3] = out[:, 1, 4] = focal * near
    out[:, :, _APPROACH] = places * near[:, None]
    along = focal * motion[_SHIFT] + motion[_APPROACH] * places
    out[:, :, _SHAPE] = along[:, :, None] * basis[:, None, :]
    return out


def _generator(motion: Points, shape: Points, focal: float) -> Points:
    """Return what a camera's motion (12,) makes of a plane that touches the scene: (3, 3)."""
    right, down, roll = motion[:3]
    aside, approach = motion[_SHIFT], motion[_APPROACH]
    slope = shape[:2]
    out = np.zeros((3, 3))
    out[:2, :2] = np.outer(aside, slope) + approach * np.eye(2) + roll * np.array([[0, -1], [1, 0]])
    out[:2, 2] = focal * (np.array([right, down]) + aside)
    out[2, :2] = -(np.array([right, down]) + approach * slope) / focal
    return out
