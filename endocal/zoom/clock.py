"""How far apart the frames of a video are, in seconds and in frames."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

# Seconds between frames where the video does not say.
USUAL_STEP = 0.04
# Within this, s or relative, a step is that of one frame: times are rounded, to milliseconds or to ticks.
_JITTER = (0.0011, 0.05)
# So many steps that none is like the period make a new one.
_STEPS = 9


class Elapsed(NamedTuple):
    """What went by since the last frame: one of the usual frames, unless told otherwise."""

    frames: float = 1.0
    seconds: float = USUAL_STEP


class FrameClock:
    """Counts what went by in the frames that are usual of late; 2 where one was dropped."""

    def __init__(self) -> None:
        self._time: float | None = None
        self._steps: deque[float] = deque(maxlen=_STEPS)
        self._period = 0.0

    def tick(self, time_s: float | None) -> tuple[Elapsed, float]:
        """Return what went by, and by how much the period, in which frames count, has changed just now.

        Where times are missing or do not advance, one frame of the period went by.
        """
        last, self._time = self._time, time_s
        if last is None or time_s is None or not time_s > last:
            return Elapsed(1.0, self._period or USUAL_STEP), 1.0
        step = time_s - last
        self._steps.append(step)
        change = 1.0
        if not self._period:
            self._period = step
        elif len(self._steps) == _STEPS and not any(self._is_frame(s) for s in self._steps):
            period = sorted(self._steps)[_STEPS // 2]
            change, self._period = period / self._period, period
        return Elapsed(1.0 if self._is_frame(step) else step / self._period, step), change

    def _is_frame(self, step: float) -> bool:
        return abs(step - self._period) <= max(_JITTER[0], _JITTER[1] * self._period)
