"""Follow the zoom through a video: the circle of each frame, over time, to the model of each frame."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..boundary.circle import Boundary
from ..boundary.detect import BoundarySpec, Located, boundary_of, locate_boundary
from ..errors import InputError
from ..model import DivisionModel
from .anchor import Anchor, AnchorSpec, Correction
from .clock import Elapsed, FrameClock
from .doubt import GrowingDoubt, doubt_after
from .outside import SeenCircle
from .parallax import ScaleStep
from .repeats import Repeats, RepeatSpec
from .rest import RestSpec, ZoomRest
from .shift import CircleShift, ShiftSpec, shifted
from .slow import SlowSpec, SlowZoom
from .smooth import DiameterFilter, SmoothingSpec
from .table import LOOKUPS, ZoomTable
from .track import ScaleTracker, TrackingSpec

Luma = NDArray[np.uint8] | NDArray[np.uint16]

SOURCES = ("rim", "tracked", "held", "given")


@dataclass(frozen=True)
class FollowSpec:
    """How a zoom is followed.

    ``lookup`` is one of LOOKUPS. The distortion centre follows the circle's shift on the sensor if it
    ``follows_shift``, else it is the table's at that diameter. ``assume_diameter`` (px) holds until a rim is
    seen, to within ``assumed_sigma`` (relative). An estimate that stands still has to leave ``still``
    (relative, least and most) before the model changes. Tracked estimates grow less certain as ``rest`` and
    ``slow`` say. Held ones grow less certain at ``held`` (relative, per s). What is in doubt of a speed keeps
    its sign for ``memory`` s, and so long a zoom may go on that nothing tells any more. After a ``cut`` of
    the scene an estimate is known to so much (relative), since any zoom may follow: 1x to 2.5x, evenly
    spread. Past ``limit`` the tracking is given up, and the last estimate held.
    """

    lookup: str = "auto"
    follows_shift: bool = True
    assume_diameter: float | None = None
    assumed_sigma: float = 0.05
    still: tuple[float, float] = (4e-4, 1.5e-3)
    held: float = 0.1
    memory: float = 0.7
    cut: float = 0.3
    limit: float = 0.15
    boundary: BoundarySpec = field(default_factory=BoundarySpec)
    repeat: RepeatSpec = field(default_factory=RepeatSpec)
    smoothing: SmoothingSpec = field(default_factory=SmoothingSpec)
    shift: ShiftSpec = field(default_factory=ShiftSpec)
    tracking: TrackingSpec = field(default_factory=TrackingSpec)
    rest: RestSpec = field(default_factory=RestSpec)
    slow: SlowSpec = field(default_factory=SlowSpec)
    anchor: AnchorSpec = field(default_factory=AnchorSpec)

    def __post_init__(self) -> None:
        if self.lookup not in LOOKUPS:
            raise ValueError(f"lookup {self.lookup!r} is none of {', '.join(LOOKUPS)}")


@dataclass(frozen=True)
class ZoomEstimate:
    """The zoom of one frame.

    ``boundary`` is the circle that was found in this very frame, if any; ``diameter`` (px) is the estimate.
    ``source`` is one of SOURCES: from the rim, tracked from the picture, held from before, or given.
    ``relative_uncertainty`` is one standard deviation of the diameter; of lambda it is twice that.
    ``shift`` (x, y) px is how far the model's centre lies from the table's, as the circle does.
    """

    model: DivisionModel
    boundary: Boundary | None
    diameter: float
    source: str
    relative_uncertainty: float
    shift: tuple[float, float] = (0.0, 0.0)


class ZoomFollower:
    """The zoom of a video, frame by frame, for a table that fits its frames' size."""

    def __init__(self, table: ZoomTable, spec: FollowSpec = FollowSpec()) -> None:
        self._table = table
        self._spec = spec
        self._filter = DiameterFilter(spec.smoothing)
        self._tracker = ScaleTracker(spec.tracking)
        self._rest = ZoomRest(spec.rest)
        self._slow = SlowZoom(spec.slow)
        self._anchor = Anchor(spec.anchor)
        self._is_tracking = False
        self._doubt = GrowingDoubt(spec.memory)
        # What was believed of slow zooms, a logarithm, since a key picture last told; their variance then.
        self._believed, self._matched = 0.0, 0.0
        # The speed of a zoom, per s, that nothing tells any more; it may go on.
        self._abandoned = 0.0
        self._clock = FrameClock()
        self._repeats = Repeats(spec.repeat)
        # What went by in frames that repeat the last one that did not, and the estimate for that.
        self._passed = Elapsed(0.0, 0.0)
        self._latest: ZoomEstimate | None = None
        self._last: Boundary | None = None
        # The last one that was believed.
        self._seen: SeenCircle | None = None
        # What the part of the rim that was last seen leaves open of its width, relative; it is no noise.
        self._shape = 0.0
        self._shift = CircleShift(table.circle_at, table.pixel_aspect, spec.shift)
        # The diameter, the shift and what the table has there, as they were last changed.
        self._current: tuple[float, tuple[float, float], DivisionModel] | None = None
        if spec.assume_diameter is not None:
            self._filter.restart(spec.assume_diameter, spec.assumed_sigma)
        self._is_assumed = spec.assume_diameter is not None
        # Whether the estimate is still the one that was assumed.
        self._is_given = self._is_assumed

    def update(self, luma: Luma, time_s: float | None = None) -> ZoomEstimate:
        """Return the estimate for the next frame, ``luma`` (h, w) uint8 or uint16.

        Raises InputError for a frame of another size, and while no rim has been seen and none is assumed.
        """
        size = (luma.shape[1], luma.shape[0])
        if size != self._table.size:
            raise InputError(
                f"the zoom table is for frames of {self._table.size[0]}x{self._table.size[1]},"
                f" not {size[0]}x{size[1]}: rescale it"
            )
        elapsed, recount = self._clock.tick(time_s)
        self._filter.recount(recount)
        elapsed = Elapsed(*(a + b for a, b in zip(self._passed, elapsed, strict=True)))
        if self._repeats.has(luma) and self._latest is not None:
            self._passed = elapsed
            return self._latest
        self._passed = Elapsed(0.0, 0.0)
        self._latest = self._look(luma, elapsed, time_s)
        return self._latest

    def _look(self, luma: Luma, elapsed: Elapsed, time_s: float | None) -> ZoomEstimate:
        """Return the estimate for a frame that is no repeat."""
        located = locate_boundary(
            luma, self._table.pixel_aspect, self._spec.boundary, guess=self._last
        )
        self._last = None if located is None else located.boundary
        if self._filter.known and not (self._is_assumed and located is not None):
            source = self._follow(luma, located, elapsed)
        elif located is not None:
            self._begin(luma, located)
            source = "rim"
        else:
            raise InputError(_nothing_known(time_s))
        return self._estimate(self._last, source)

    def _begin(self, luma: Luma, located: Located) -> None:
        """Take the first rim that is seen as it is."""
        diameter = located.boundary.diameter
        smoothing = self._spec.smoothing
        sigma = max(located.diameter_sigma / diameter, smoothing.floor)
        self._filter.restart(diameter, sigma, smoothing.max_speed / 4)
        self._take_rim(luma, located)
        self._is_assumed = self._is_given = self._is_tracking = False

    def _follow(self, luma: Luma, located: Located | None, elapsed: Elapsed) -> str:
        """Advance by one frame and what it showed, and name where the estimate comes from."""
        self._shift.advance(elapsed.frames)
        tracked = self._advance(luma, elapsed, lost=located is None)
        if located is None:
            self._is_given = self._is_given and not tracked
            return tracked or ("given" if self._is_given else "held")
        diameter = located.boundary.diameter
        if self._filter.correct(diameter, located.diameter_sigma / diameter):
            self._is_tracking = False
            self._take_rim(luma, located)
            return "rim"
        if self._filter.is_pause(elapsed):
            # What was before a pause says nothing against what is seen after it.
            self._begin(luma, located)
            return "rim"
        return tracked or "held"

    def _take_rim(self, luma: Luma, located: Located) -> None:
        """Learn from a rim what else it tells than the diameter."""
        self._shape = located.shape_sigma / located.boundary.diameter
        self._seen = SeenCircle(luma, located.boundary, self._table.pixel_aspect)
        if self._spec.follows_shift:
            self._shift.measure(located, self._filter.diameter)

    def _advance(self, luma: Luma, elapsed: Elapsed, lost: bool) -> str:
        """Predict this frame's diameter from the last; returns "tracked" where the picture told it."""
        state, spec, seconds = self._filter, self._spec, elapsed.seconds
        if not self._is_tracking:
            # The speed so far carries over the first frame without a rim; the tracker starts from there.
            state.predict(elapsed)
            if state.is_pause(elapsed):
                state.widen(doubt_after(spec.held, spec.memory, seconds))
            if lost:
                self._tracker.forget()
                speed = state.speed * elapsed.frames / seconds
                self._rest.forget(speed if state.is_moving else None)
                self._slow.restart()
                self._doubt.restart()
                self._tracker.step(luma, self._table, state.diameter, shift=self._shift.value)
                self._anchor.forget()
                if self._tracker.picture is not None:
                    self._anchor.begin(
                        self._tracker.picture, self._table, state.diameter, self._shift.value
                    )
                self._is_tracking = True
                self._abandoned = self._believed = self._matched = 0.0
                if self._seen is not None and self._seen.is_outgrown(luma, state.diameter):
                    # The rim is not where the speed so far takes it: this is no zoom that went on.
                    state.widen(spec.cut)
            return ""
        step = None
        if self._sigma < spec.limit:
            step = self._tracker.step(
                luma,
                self._table,
                state.diameter,
                self._rest.rests,
                self._shift.value,
                self._rest.hand * seconds,
            )
            if self._tracker.was_cut:
                state.widen(spec.cut)
                self._anchor.forget()
                step = None
        if step is None:
            self._rest.forget()
            self._abandon(elapsed, seconds)
            deviation = math.hypot(spec.held, self._abandoned)
            growth = self._doubt.grow(deviation, seconds)
            state.scale(0.0, math.sqrt(growth), elapsed)
            self._anchor.doubt(growth)
            return ""
        self._abandoned = 0.0
        zoom = self._rest.take(step, seconds)
        before = self._slow.logarithm
        self._slow.take(zoom.seeming, zoom.seeming_doubt, seconds)
        believed = self._slow.logarithm - before
        self._believed += believed
        logarithm = zoom.logarithm + believed
        growth = self._doubt.grow(zoom.doubt, seconds)
        state.scale(logarithm, math.sqrt(growth), elapsed)
        self._anchor.doubt(growth)
        self._hold(step, seconds)
        return "tracked"

    def _hold(self, step: ScaleStep, seconds: float) -> None:
        """Hold the sum of the steps to what the key picture says."""
        picture = self._tracker.picture
        if picture is None:
            return
        more = self._anchor.take(
            picture,
            self._table,
            self._filter.diameter,
            self._shift.value,
            step,
            seconds,
            self._slow.sigma**2,
        )
        if more != Correction():
            self._filter.pull(more.logarithm, more.variance)
            self._believed, self._matched = 0.0, self._slow.sigma**2

    def _abandon(self, elapsed: Elapsed, seconds: float) -> None:
        """Stop, and remember for a while the speed that a zoom had till now."""
        speed = abs(self._filter.speed) * elapsed.frames / elapsed.seconds
        kept = math.exp(-seconds / self._spec.memory)
        self._abandoned = max(speed, kept * self._abandoned)
        self._filter.stop()

    @property
    def _sigma(self) -> float:
        """One standard deviation of the diameter, relative."""
        if not self._is_tracking:
            return self._filter.sigma
        # What a key picture tells it tells of slow zooms as well.
        # But not of what was believed of them since, nor what they are less in doubt than then.
        since = self._believed**2 + max(self._matched - self._slow.sigma**2, 0.0)
        owed = max(self._filter.owed - since, 0.0)
        variance = self._filter.sigma**2 + self._slow.sigma**2 - owed
        return max(math.sqrt(max(variance, 0.0)), self._spec.smoothing.floor)

    def _estimate(self, boundary: Boundary | None, source: str) -> ZoomEstimate:
        state, (least, most) = self._filter, self._spec.still
        diameter = state.diameter
        if self._current is not None:
            moved = abs(math.log(diameter / self._current[0]))
            slack = least / 4 if state.is_moving else min(max(least, 2 * state.sigma), most)
            if moved <= slack:
                diameter = self._current[0]
        shift = self._shift.value
        if self._current is None or (diameter, shift) != self._current[:2]:
            model = shifted(self._look_up(diameter, boundary), shift)
            self._current = (diameter, shift, model)
        # What is shown stands still while the estimate moves within the slack.
        behind = math.log(diameter / state.diameter)
        cut = self._spec.cut if self._is_tracking and self._tracker.may_be_cut else 0.0
        sigma = math.hypot(self._sigma, state.pending, self._shape, behind, cut)
        return ZoomEstimate(self._current[2], boundary, diameter, source, sigma, shift)

    def _look_up(self, diameter: float, boundary: Boundary | None) -> DivisionModel:
        if self._spec.lookup == "area" and boundary is not None:
            smoothed = boundary_of(
                boundary.center, diameter, self._table.size, self._table.pixel_aspect
            )
            return self._table.at(smoothed, "area")
        return self._table.at_diameter(
            diameter, "diameter" if self._spec.lookup == "area" else self._spec.lookup
        )


def _nothing_known(time_s: float | None) -> str:
    when = "" if time_s is None else f" at {time_s:.2f} s"
    return (
        f"no visible circle{when}, and none before it: the zoom is not known; give --zoom-from or"
        " --assume-diameter"
    )
