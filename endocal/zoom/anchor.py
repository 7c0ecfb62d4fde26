"""Holds what the steps from frame to frame add up to to the zoom since a key picture.

The key is renewed where too little of it is left in the picture, or where it is seen too small or too large;
the zoom of the new one is what was known then.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from .key import KeyPicture, KeySpec
from .likeness import Likeness
from .matching import Luma
from .parallax import ScaleStep
from .planar import PlanarFit
from .shift import Offset
from .table import ZoomTable
from .view import USUAL_FOCAL, center_drift, guessed_focal, view_at

# The least part of a match's weight that a rough scene leaves: it only keeps its doubt finite.
_LITTLE = 1e-6


@dataclass(frozen=True)
class AnchorSpec:
    """When a key picture is matched and renewed, and how well it tells.

    It is matched every ``interval`` s, and renewed where fewer than ``few`` of its places are found or its
    scale has changed by more than ``scale``. A hand comes nearer by ``hand`` (a logarithm per s, one standard
    deviation). A match is off by ``least`` (relative), and by ``bends`` of how far the hand went aside times
    the scene's curvature. ``focal`` is lam f^2 of a usual lens, without its sign. What is rough about a scene
    deceives steps and matches together: in full it takes the part ``together`` of a match's weight, and so
    much their errors correlate.
    """

    interval: float = 0.24
    few: int = 40
    scale: float = 1.5
    hand: float = 0.03
    least: float = 0.0015
    bends: float = 3.0
    focal: float = USUAL_FOCAL
    together: float = 0.7
    key: KeySpec = field(default_factory=KeySpec)


class Correction(NamedTuple):
    """What is to be added to the logarithm of the diameter, and to be taken from its variance."""

    logarithm: float = 0.0
    variance: float = 0.0


class Anchor:
    """Compares what steps add up to with the zoom since a key picture."""

    def __init__(self, spec: AnchorSpec = AnchorSpec()) -> None:
        self._spec = spec
        self._key: KeyPicture | None = None
        self._likeness = Likeness(spec.key.planar.remembered)
        # The diameter in the key picture, px, and the variance of what steps have added up to since.
        self._diameter, self._variance = 0.0, 0.0
        # How far they say that the hand went aside, and the farthest that the picture did, in distances.
        self._aside, self._farthest = np.zeros(2), 0.0
        # What was added to that sum till now, and what taken from its variance.
        self._given = Correction()
        # Seconds since the key picture, and since it was last matched.
        self._seconds = self._due = 0.0

    def forget(self) -> None:
        """Begin anew with the next picture."""
        self._key = None
        self._likeness = Likeness(self._spec.key.planar.remembered)

    def begin(self, picture: Luma, table: ZoomTable, diameter: float, shift: Offset) -> None:
        """Make a picture the key, at its ``diameter`` px and the circle's ``shift`` (x, y) px."""
        view = view_at(table, diameter, shift, _reduction(picture, table))
        self._key = KeyPicture(picture, view, self._spec.key)
        self._diameter, self._variance = diameter, 0.0
        self._aside, self._farthest = np.zeros(2), 0.0
        self._given = Correction()
        self._seconds = self._due = 0.0

    def doubt(self, variance: float) -> None:
        """Take in by how much the variance of the sum has grown."""
        self._variance += variance

    def take(
        self,
        picture: Luma,
        table: ZoomTable,
        diameter: float,
        shift: Offset,
        step: ScaleStep,
        seconds: float,
        slow: float,
    ) -> Correction:
        """Return what the key says of the ``diameter`` px that was found for a ``picture``.

        A ``step`` of so many ``seconds`` led to it. ``slow`` is the variance of slow zooms, which counts
        besides that which has added up.
        """
        spec, key = self._spec, self._key
        if key is None:
            self.begin(picture, table, diameter, shift)
            return Correction()
        key.go_on(step.generator, step.logarithm)
        self._aside = self._aside + step.aside
        self._farthest = max(self._farthest, key.motion.aside)
        self._seconds += seconds
        self._due += seconds
        if self._due < spec.interval - seconds / 2:
            return Correction()
        self._due = 0.0
        taken = self._diameter * math.exp(key.motion.logarithm)
        view = view_at(table, taken, shift, _reduction(picture, table))
        hand = spec.hand * self._seconds
        fit = key.match(picture, view, center_drift(table, taken), hand, self._likeness)
        more = Correction()
        if fit is not None:
            own = math.log(diameter / self._diameter) - self._given.logarithm
            bent = self._bent(key, step.curved)
            given = self._weigh(fit, step, own, self._variance + slow, bent)
            more = Correction(*(a - b for a, b in zip(given, self._given, strict=True)))
            self._given = given
        if fit is None or key.found < spec.few or not self._is_alike(fit.motion.scale):
            self.begin(picture, table, diameter * math.exp(more.logarithm), shift)
        return more

    def _weigh(
        self, fit: PlanarFit, step: ScaleStep, own: float, variance: float, bent: float
    ) -> Correction:
        """Weigh a match against what steps add up to: the logarithm ``own``, known to a ``variance``.

        ``bent`` is by how much a curved scene may put the match off.
        """
        spec = self._spec
        together = spec.together * fit.shared
        match = fit.sigma**2 + spec.least**2 + bent**2
        # Errors that last from step to step are no smaller in a match.
        match /= max((1 - together) * (1 - step.lasting), _LITTLE)
        both = together * math.sqrt(variance * match)
        weight = (variance - both) / (variance + match - 2 * both)
        weight = min(max(weight, 0.0), 1.0)
        left = (1 - weight) ** 2 * variance + weight**2 * match + 2 * weight * (1 - weight) * both
        return Correction(weight * (fit.motion.logarithm - own), variance - left)

    def _bent(self, key: KeyPicture, curved: float) -> float:
        """Return by how much the zoom is off since no homography knows of a scene that is ``curved``.

        That counts as far as the hand went aside. What steps add up to of that is little where the picture
        stayed where it was.
        """
        far = self._farthest / guessed_focal(*key.view.strengths, self._spec.focal)
        return self._spec.bends * curved * min(math.hypot(*self._aside), far)

    def _is_alike(self, scale: float) -> bool:
        """Say whether the key is seen at about the ``scale`` that it had."""
        return 1 / self._spec.scale < scale < self._spec.scale


def _reduction(picture: Luma, table: ZoomTable) -> int:
    return max(1, round(table.size[1] / picture.shape[0]))
