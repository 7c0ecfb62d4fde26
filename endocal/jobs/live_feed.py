"""A live input on its way through: when each frame came, how late it left, and how to end."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from statistics import median

from ..video.reader import Item, is_frame

# Latencies are kept for so many frames, which is minutes.
_KEPT = 10_000


@dataclass(frozen=True)
class Latency:
    """From a frame's arrival to its leaving the encoder, ms; ``dropped`` frames were left out to keep up."""

    median: float
    most: float
    dropped: int


class LiveFeed:
    """The items of a live reader, with times from zero on, until somebody says stop."""

    def __init__(self) -> None:
        self._arrivals: dict[int, float] = {}
        self._lock = threading.Lock()
        self._stopped = threading.Event()
        self._latencies: deque[float] = deque(maxlen=_KEPT)
        self._start: Fraction | None = None
        self.dropped = 0

    def stop(self) -> None:
        """Let the feed end after the item that comes next."""
        self._stopped.set()

    def items(self, source: Iterable[Item]) -> Iterator[Item]:
        """Yield the items of ``source`` from its first frame on, and note when each frame came."""
        for item in source:
            if self._stopped.is_set():
                return
            if self._start is None:
                if not is_frame(item) or item.pts is None or item.time_base is None:
                    continue
                self._start = item.pts * item.time_base
            if item.pts is None or item.time_base is None:
                continue
            shift = round(self._start / item.time_base)
            item.pts -= shift
            if not is_frame(item):
                item.dts = None if item.dts is None else item.dts - shift
                if item.pts < 0:
                    continue
            else:
                with self._lock:
                    self._arrivals[item.pts] = time.monotonic()
            yield item

    def drop(self, item: Item) -> None:
        """Note that a frame was left out."""
        self.dropped += 1

    def left(self, pts: int) -> None:
        """Note that the frame of this time has left the encoder."""
        now = time.monotonic()
        with self._lock:
            arrived = self._arrivals.pop(pts, None)
            # Those before it will not leave any more.
            for earlier in [p for p in self._arrivals if p < pts]:
                del self._arrivals[earlier]
        if arrived is not None:
            self._latencies.append((now - arrived) * 1000)

    def latency(self) -> Latency | None:
        """Return how late the frames were; None before the first has left."""
        if not self._latencies:
            return None
        return Latency(
            round(median(self._latencies), 1), round(max(self._latencies), 1), self.dropped
        )
