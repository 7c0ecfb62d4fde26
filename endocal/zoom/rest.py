"""Whether the zoom moves at all: a zoom ring rests most of the time, a hand never does.

In a cavity whose walls come nearer towards the rim, a zoom and a camera that comes nearer look much alike,
and the slow to and fro of a hand would add up to a false zoom. So slow changes are put down to the hand,
until they are too fast for one.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

from .track import ScaleStep


@dataclass(frozen=True)
class RestSpec:
    """When a zoom is taken to move: by its mean over ``window`` s.

    It must be faster than ``rest`` (relative, per s), and than ``share`` of what the camera does at the same
    time.
    """

    window: float = 0.32
    rest: float = 0.035
    share: float = 0.5


class ZoomRest:
    """Lets the steps of a moving zoom through, those from before it was noticed included."""

    def __init__(self, spec: RestSpec = RestSpec()) -> None:
        self._spec = spec
        self._steps: deque[tuple[float, float, float]] = deque()
        self._is_moving = False

    def forget(self) -> None:
        """Begin anew, at rest."""
        self._steps.clear()
        self._is_moving = False

    def take(self, step: ScaleStep, seconds: float) -> float:
        """Return the logarithm of the scale to apply after ``seconds`` s; 0 at rest."""
        steps, spec = self._steps, self._spec
        steps.append((step.logarithm, step.approach, seconds))
        while len(steps) > 1 and sum(s[2] for s in steps) > spec.window:
            steps.popleft()
        zoom, approach, duration = (sum(column) for column in zip(*steps, strict=True))
        was_moving = self._is_moving
        self._is_moving = abs(zoom) > spec.rest * duration + spec.share * abs(approach)
        if not self._is_moving:
            return 0.0
        return step.logarithm if was_moving else zoom
