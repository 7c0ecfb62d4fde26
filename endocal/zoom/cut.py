"""Scene cuts: a recording that was joined or paused shows another picture from one frame to the next.

A flash, smoke or a blur breaks the track of a scene as well, but not for good: a moment later the picture
is the one from before. So after a break the next few pictures are held against the last one before it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .matching import Luma, Places, evened, follow_places


@dataclass(frozen=True)
class CutSpec:
    """When the scene is taken to have been cut.

    A picture in which no more than ``lost`` of the places are found again is not of the same scene, or shows
    nothing of it; where ``matched`` of them are, the scene goes on. Before a camera that moves 75 to 100 %
    are found in the next frame and ten frames on half of them, in another scene 0 to 15 %. So many ``frames``
    a scene has to come back: later a camera may have moved on.
    """

    lost: float = 0.1
    matched: float = 0.4
    frames: int = 10


class _Reference(NamedTuple):
    """The last picture before a break, and places in it, (n, 1, 2) px."""

    image: Luma
    places: Places


class CutDetector:
    """Watches over the matching of successive pictures."""

    def __init__(self, spec: CutSpec = CutSpec()) -> None:
        self._spec = spec
        self._reference: _Reference | None = None
        self._since = 0
        self._is_likely = False

    @property
    def is_likely(self) -> bool:
        """Say whether what is shown goes on, and is not what was shown before a break a few frames ago."""
        return self._is_likely

    def forget(self) -> None:
        """Begin anew."""
        self._reference, self._is_likely = None, False

    def take(self, last: Luma, places: Places, current: Luma, found: NDArray[np.bool_]) -> bool:
        """Say whether the scene was cut a few frames ago, now that this is known.

        ``found`` (n,) says which of the ``places`` of the last picture were found in the ``current`` one.
        """
        spec = self._spec
        share = float(found.mean()) if len(found) else 0.0
        reference, self._is_likely = self._reference, False
        if reference is None:
            if share <= spec.lost and len(places):
                self._reference, self._since = _Reference(last, places), 0
            return False
        self._since += 1
        goes_on = share >= spec.matched
        if goes_on and _is_seen(reference, current, spec.lost):
            self._reference = None
            return False
        if self._since < spec.frames:
            self._is_likely = goes_on
            return False
        self._reference = None
        # Of pictures that are not alike either, nothing is known.
        return goes_on


def _is_seen(reference: _Reference, image: Luma, lost: float) -> bool:
    """Say whether more than a share of ``lost`` of the reference's places are in a picture."""
    _, found = follow_places(evened(reference.image), evened(image), reference.places)
    return float(found.mean()) > lost
