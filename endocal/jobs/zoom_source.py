"""The model of each frame from a zoom table: by the frame's own circle, or by a record."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

import numpy as np

from ..boundary.circle import Boundary
from ..boundary.detect import find_boundary
from ..errors import InputError
from ..model import DivisionModel
from ..zoom.follow import FollowSpec, ZoomEstimate, ZoomFollower
from ..zoom.shift import shifted
from ..zoom.table import ZoomTable
from .first_circle import Ahead, FirstCircle, first_circle
from .zoom_bounds import beyond_table, check_named, check_recorded
from .zoom_log import RecordedZoom, ZoomLog, ZoomRecord


class FollowedZoom:
    """A zoom table, and for each frame the diameter to look it up by: of its own circle, or recorded.

    Each frame's zoom goes to ``log``, if there is one. Where the first frames show no circle (a fade from
    black, a cloth before the lens, a rim out of the frame), the first one in ``ahead``, the video's luma and
    times from its start, holds for them; ``notes`` says so, and where the zoom leaves the calibrated range.
    Raises UsageError for an assumed diameter, and InputError for a recorded zoom, that no circle before this
    lens can have; and InputError for a table that lacks what the look-up or the centre goes by.
    """

    def __init__(
        self,
        table: ZoomTable,
        lookup: str,
        center: str,
        assume_diameter: float | None,
        recorded: RecordedZoom | None,
        log: ZoomLog | None,
        ahead: Ahead | None,
    ) -> None:
        follows_shift = center != "fixed"
        self.notes: list[str] = []
        if assume_diameter is not None:
            check_named("--assume-diameter", assume_diameter, table, lookup)
        if recorded is not None:
            check_recorded(recorded, table, lookup, follows_shift)
        else:
            table.check_lookup(lookup)
            self._check_circles(table, center)
        if recorded is not None and lookup == "area":
            self.notes.append(
                "--zoom-from tells diameters and no areas: instead of --lookup area, --lookup diameter holds"
            )
        self._ahead = ahead
        self._table = table
        self._lookup = lookup
        self._follows_shift = follows_shift
        self._recorded = recorded
        self._log = log
        self._follower = ZoomFollower(table, FollowSpec(lookup, follows_shift, assume_diameter))
        # Until a circle is seen or one is assumed, there is nothing to follow.
        self._has_begun = assume_diameter is not None
        self._first: FirstCircle | None = None
        self._frame = 0
        self._has_left_range = False
        self.models = tuple(table.at_diameter(s.diameter) for s in table.settings)
        # Where a table does not tell its circles' centres, they are near the lens's.
        self.boundaries: tuple[Boundary | None, ...] = tuple(
            Boundary(s.circle or s.center, s.diameter, s.area or 0.0, 1.0) for s in table.settings
        )
        self.sources: Counter[str] = Counter()
        self.diameters: tuple[float, float] | None = None

    def model(self, luma: Callable[[], np.ndarray], time_s: float | None) -> DivisionModel:
        """Measure the circle in the frame, or look up the record, and return the model of its zoom."""
        if self._recorded is None:
            estimate = self._follow(luma(), time_s)
        else:
            diameter = self._recorded.diameter(self._frame, time_s)
            shift = (0.0, 0.0)
            if self._follows_shift:
                shift = self._recorded.shift(self._frame, time_s)
            model = shifted(self._table.at_diameter(diameter, self._lookup), shift)
            doubt = self._recorded.uncertainty(self._frame, time_s)
            estimate = ZoomEstimate(model, None, diameter, "given", doubt, shift)
        self.sources[estimate.source] += 1
        self._watch_range(estimate.diameter, time_s)
        least, most = self.diameters or (estimate.diameter, estimate.diameter)
        self.diameters = (min(least, estimate.diameter), max(most, estimate.diameter))
        if self._log is not None:
            self._log.add(
                ZoomRecord(
                    self._frame,
                    time_s,
                    estimate.diameter,
                    estimate.source,
                    estimate.model,
                    estimate.relative_uncertainty,
                    estimate.shift,
                )
            )
        self._frame += 1
        return estimate.model

    def _check_circles(self, table: ZoomTable, center: str) -> None:
        """Without the places of all its circles a table does not tell how far one was shifted."""
        lacking = [s.title for s in table.settings if s.circle is None]
        if not lacking or center == "fixed":
            return
        if center == "follow":
            raise InputError(
                "--center follow: the zoom table does not tell where its visible circle was, at"
                f" {' and '.join(lacking)}; make the table from calibrations that show the rim"
            )
        self.notes.append(
            "the table does not tell where its circles are: the distortion centre does not follow the"
            " circle's shift"
        )

    def _watch_range(self, diameter: float, time_s: float | None) -> None:
        """Note the first time that the zoom leaves what was calibrated."""
        if self._has_left_range or self._table.covers(diameter):
            return
        self._has_left_range = True
        when = f"frame {self._frame}" if time_s is None else f"{time_s:.2f} s"
        self.notes.append(beyond_table(diameter, self._table, f" at {when}"))

    def _follow(self, luma: np.ndarray, time_s: float | None) -> ZoomEstimate:
        shows_circle = self._has_begun or (
            # Any circle before the first one that is confirmed is a false one.
            (self._first is None or self._first.may_begin(self._frame))
            and find_boundary(luma, self._table.pixel_aspect) is not None
        )
        if shows_circle or self._ahead is None:
            self._has_begun = True
            return self._follower.update(luma, time_s)
        if self._first is None:
            self._first = first_circle(self._ahead, self._table, self._lookup, self._follows_shift)
            diameter = self._first.seen.diameter
            self.notes.append(
                f"the first frames show no circle; the first one seen, {diameter:.1f} px wide, holds for them"
            )
        return self._first.held(self._frame, time_s)
