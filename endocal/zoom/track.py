"""The zoom from the picture itself, for when the circle's rim is out of the frame.

Places of the scene are followed from frame to frame; ``parallax`` tells what a zoom and what a moving camera
made of them.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from .cut import CutDetector, CutSpec
from .matching import Luma, Places, best_corners, evened, follow_places
from .parallax import MotionSpec, ScaleStep, SceneShape
from .shift import Offset
from .table import ZoomTable
from .view import View, center_drift, view_at

# Bits to a sample that cameras and codecs know.
_DEPTHS = (8, 10, 12, 14, 16)


@dataclass(frozen=True)
class TrackingSpec:
    """How the zoom is tracked.

    The picture is reduced to about ``height`` px, and up to ``points`` places are followed in it, ``spacing``
    reduced px apart and not nearer to the rim than at ``reach`` of the circle's radius; in a soft picture a
    corner counts from ``worth`` of its median strength on. With fewer than ``least`` the step is given up;
    new ones are sought below ``renew`` of those that were found. ``noise`` is the least error of a followed
    place, reduced px.
    """

    height: int = 360
    points: int = 200
    reach: float = 0.94
    least: int = 24
    renew: float = 0.8
    noise: float = 0.05
    spacing: float = 18.0
    worth: float = 1.0
    motion: MotionSpec = field(default_factory=MotionSpec)
    cut: CutSpec = field(default_factory=CutSpec)


class ScaleTracker:
    """Follows the scale of successive frames of one size."""

    def __init__(self, spec: TrackingSpec = TrackingSpec()) -> None:
        self._spec = spec
        self._last: Luma | None = None
        self._places = np.empty((0, 1, 2), np.float32)
        self._sought = 0
        self._depth = _DEPTHS[0]
        self._scene = SceneShape(spec.motion)
        self._cut = CutDetector(spec.cut)
        self._was_cut = False

    @property
    def picture(self) -> Luma | None:
        """The last picture, reduced."""
        return self._last

    @property
    def was_cut(self) -> bool:
        """Say whether the last step showed that the scene was cut, a few frames ago."""
        return self._was_cut

    @property
    def may_be_cut(self) -> bool:
        """Say whether the last frame is likely to show another scene than a few frames ago."""
        return self._cut.is_likely

    def forget(self) -> None:
        """Begin anew with the next frame."""
        self._last = None
        self._was_cut = False
        self._scene = SceneShape(self._spec.motion)
        self._cut.forget()

    def step(
        self,
        luma: NDArray[np.uint8] | NDArray[np.uint16],
        table: ZoomTable,
        diameter: float,
        rests: bool = False,
        shift: Offset = (0.0, 0.0),
        hand: float | None = None,
    ) -> ScaleStep | None:
        """Return the scale from the last frame to this one; None where it cannot be told.

        ``diameter`` (px) is that of the last frame, which the ``table`` has the model for; ``rests`` says
        whether the zoom was at rest, and ``shift`` (x, y) px how far its centre lies from the table's.
        ``hand`` is how much nearer the camera is expected to come meanwhile, in distances to the scene.
        """
        reduction = max(1, round(luma.shape[0] / self._spec.height))
        view = view_at(table, diameter, shift, reduction)
        current = self._reduced(luma, reduction)
        last, self._last = self._last, current
        self._was_cut = False
        if last is None or last.shape != current.shape:
            self._places, self._sought = self._places[:0], 0
            return None
        if len(self._places) <= self._spec.renew * self._sought:
            self._places = self._seek(last, view)
            self._sought = len(self._places)
        moved, found = self._follow(last, current)
        self._was_cut = self._cut.take(last, self._places, current, found)
        before, after = self._places[found][:, 0], moved[found][:, 0]
        self._places = moved[found]
        if len(after) < self._spec.least:
            return None
        return self._scene.scale_between(
            view.offsets(before),
            view.offsets(after),
            view.model,
            diameter,
            center_drift(table, diameter),
            self._spec.noise * reduction,
            rests,
            hand,
        )

    def _follow(self, last: Luma, current: Luma) -> tuple[Places, NDArray[np.bool_]]:
        """Return where the places are now, and which of them were found; none of fewer than ``least``."""
        if len(self._places) < self._spec.least:
            return self._places, np.zeros(len(self._places), np.bool_)
        moved, found = follow_places(last, current, self._places)
        if found.mean() <= self._spec.cut.lost:
            # Another light is no other scene.
            moved, found = follow_places(evened(last), evened(current), self._places)
        return moved, found

    def _reduced(self, luma: NDArray[np.uint8] | NDArray[np.uint16], reduction: int) -> Luma:
        """Average the picture over blocks of ``reduction`` px, in 8 bit.

        The depth is the one that the brightest value so far needs. It never falls: light that flickers must
        not change by how much successive pictures are darkened.
        """
        size = (luma.shape[1] // reduction, luma.shape[0] // reduction)
        small = np.asarray(cv2.resize(luma, size, interpolation=cv2.INTER_AREA), luma.dtype)
        if small.dtype == np.uint8:
            return np.asarray(small, np.uint8)
        brightest = int(small.max())
        depth = max(self._depth, next(d for d in _DEPTHS if brightest < 1 << d))
        if self._last is not None:
            self._last = np.asarray(self._last // (1 << depth - self._depth), np.uint8)
        self._depth = depth
        return (small // (1 << depth - _DEPTHS[0])).astype(np.uint8)

    def _seek(self, image: Luma, view: View) -> Places:
        """Find places that can be followed, away from the rim; (n, 1, 2) reduced px."""
        spec = self._spec
        places = best_corners(image, spec.points, spec.spacing, spec.worth)
        offset = view.offsets(places[:, 0])
        return places[np.hypot(offset[:, 0], offset[:, 1]) < spec.reach * view.diameter / 2]
