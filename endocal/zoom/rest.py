"""Whether the zoom moves at all: a zoom ring rests most of the time, a hand never does.

What a zoom and what a moving camera made of the picture is told apart only as well as the scene's shape is
known, and the slow to and fro of a hand would add up to a false zoom. So slow changes are put down to the
hand, until they are too fast for one; and what seemed a slow zoom just before is taken off those.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

from .parallax import ScaleStep


@dataclass(frozen=True)
class RestSpec:
    """When a zoom is taken to move: by its mean over ``window`` s.

    It must be faster than ``rest`` (relative, per s), and than ``share`` of what the camera does at the same
    time. What seemed a zoom at rest is remembered, and forgotten, within ``memory`` s.
    """

    window: float = 0.32
    rest: float = 0.035
    share: float = 0.5
    memory: float = 1.0


class ZoomRest:
    """Lets the steps of a moving zoom through, those from before it was noticed included."""

    def __init__(self, spec: RestSpec = RestSpec()) -> None:
        self._spec = spec
        self._steps: deque[tuple[float, float, float]] = deque()
        self._is_moving = False
        self._false_speed = 0.0

    def forget(self) -> None:
        """Begin anew, at rest."""
        self._steps.clear()
        self._is_moving = False
        self._false_speed = 0.0

    def take(self, step: ScaleStep, seconds: float) -> float:
        """Return the logarithm of the scale to apply after ``seconds`` s; 0 at rest."""
        steps, spec = self._steps, self._spec
        steps.append((step.logarithm, step.approach, seconds))
        while len(steps) > 1 and sum(s[2] for s in steps) > spec.window:
            logarithm, _, duration = steps.popleft()
            self._remember(0.0 if self._is_moving else logarithm / duration, duration)
        zoom, approach, duration = (sum(column) for column in zip(*steps, strict=True))
        zoom -= self._false_speed * duration
        was_moving = self._is_moving
        self._is_moving = abs(zoom) > spec.rest * duration + spec.share * abs(approach)
        if not self._is_moving:
            return 0.0
        return step.logarithm - self._false_speed * seconds if was_moving else zoom

    def _remember(self, speed: float, seconds: float) -> None:
        """Take in the speed of a zoom, per s, that was none."""
        self._false_speed += (1 - math.exp(-seconds / self._spec.memory)) * (
            speed - self._false_speed
        )
