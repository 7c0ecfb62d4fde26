"""The first visible circle of a video, for the frames before it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..boundary.detect import Located, boundary_of, locate_boundary
from ..errors import InputError
from ..zoom.clock import USUAL_STEP
from ..zoom.doubt import doubt_after
from ..zoom.follow import FollowSpec, ZoomEstimate
from ..zoom.shift import offset, shifted
from ..zoom.table import ZoomTable

# The luma of a video's frames and their times in s, from its start on, as often as asked.
Ahead = Callable[[], Iterator[tuple[np.ndarray, float | None]]]
# Looking for the first circle, every so many frames are enough.
_LOOK_EVERY = 4
# Relative change of a diameter from frame to frame by the fastest hand: it doubles in a second.
_FASTEST = 0.03


class FirstCircle(NamedTuple):
    """The first circle of a video: the zoom that it tells, and the number and time, in s, of its frame."""

    seen: ZoomEstimate
    number: int
    time: float | None

    def may_begin(self, number: int) -> bool:
        """Say whether a frame may show this circle: those since the last look, and all later ones."""
        return number > self.number - _LOOK_EVERY

    def held(self, number: int, time: float | None) -> ZoomEstimate:
        """Return the estimate for a frame that shows no circle: this one's, in more doubt the further off."""
        if time is None or self.time is None:
            away = abs(self.number - number) * USUAL_STEP
        else:
            away = abs(self.time - time)
        spec = FollowSpec()
        doubt = doubt_after(spec.held, spec.memory, away)
        sigma = math.hypot(self.seen.relative_uncertainty, doubt)
        return replace(self.seen, relative_uncertainty=sigma)


def first_circle(ahead: Ahead, table: ZoomTable, lookup: str, follows_shift: bool) -> FirstCircle:
    """Look for the first circle in the video that the next look confirms, so that no single false one counts.

    Where none is confirmed until the video ends, the first one that was seen at all. ``lookup`` and
    ``follows_shift``: see FollowSpec. Raises InputError where no frame that can be read shows one.
    """
    has_frames = False
    first: _Sighting | None = None
    last: _Sighting | None = None
    for number, (luma, time) in itertools.islice(enumerate(ahead()), 0, None, _LOOK_EVERY):
        has_frames = True
        located = locate_boundary(luma, table.pixel_aspect)
        seen = None if located is None else _Sighting(located, number, time)
        if seen is not None and last is not None and seen.confirms(last):
            first = last
            break
        first, last = first or seen, seen
    if first is not None:
        return first.read(table, lookup, follows_shift)
    # A pipe and a live input give their frames once.
    which = "no frame shows" if has_frames else "the first frame does not show"
    raise InputError(
        f"{which} a visible circle: the zoom is not known; give --zoom-from or --assume-diameter"
    )


class _Sighting(NamedTuple):
    """A circle that was found in a frame, and the number and time, in s, of that frame."""

    located: Located
    number: int
    time: float | None

    def confirms(self, before: _Sighting) -> bool:
        """Say whether this may be the same circle as one a look ago."""
        ratio = self.located.boundary.diameter / before.located.boundary.diameter
        return abs(math.log(ratio)) < _FASTEST * (self.number - before.number)

    def read(self, table: ZoomTable, lookup: str, follows_shift: bool) -> FirstCircle:
        """Look the lens up that this circle tells."""
        place, diameter = self.located.boundary.center, self.located.boundary.diameter
        boundary = boundary_of(place, diameter, table.size, table.pixel_aspect)
        sigma = self.located.uncertainty / diameter
        shift = (offset(place, table.circle_at(diameter)) if follows_shift else None) or (0.0, 0.0)
        model = shifted(table.at(boundary, lookup), shift)
        estimate = ZoomEstimate(model, None, diameter, "held", sigma, shift)
        return FirstCircle(estimate, self.number, self.time)
