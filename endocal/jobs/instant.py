"""An instant of a video: a frame's number or a time."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..errors import UsageError


@dataclass(frozen=True)
class Instant:
    """The frame of that number, from 0, or else the one that is shown at that time, s from the start."""

    frame: int | None = None
    time: float | None = None

    @classmethod
    def parse(cls, text: str) -> Instant:
        """Read ``250`` as a frame; ``12.5s``, ``12.5`` and ``1:02:03.5`` as times. Raises UsageError."""
        if text.isdecimal():
            return cls(frame=int(text))
        parts = text.removesuffix("s").split(":")
        try:
            values = [float(part) for part in parts]
        except ValueError:
            values = []
        fits = 1 <= len(values) <= 3 and all(v < 60 for v in values[1:])
        if not (fits and all(math.isfinite(v) and v >= 0 for v in values)):
            raise UsageError(
                f"{text!r} is no instant: write a frame's number (250) or a time (12.5s, 1:02:03.5)"
            )
        seconds = 0.0
        for value in values:
            seconds = 60 * seconds + value
        return cls(time=seconds)

    def __str__(self) -> str:
        return f"frame {self.frame}" if self.time is None else f"{self.time:g} s"
