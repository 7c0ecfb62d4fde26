"""Interlaced video: seeing it, and making whole frames of it before they are remapped.

A woven frame holds two moments on alternate rows. Remapped as it is, rows of both moments mix and no
later filter can part them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from itertools import pairwise

import av
import av.filter
import numpy as np

from .reader import Item, is_frame
from .stream import StreamInfo

# Interlaced formats have at most this many rows; 720 rows are progressive in every standard.
_MAX_ROWS = 1088
_PROGRESSIVE_ROWS = (720,)
# Comb teeth lower than this are noise, grey levels of 8 bit.
_TOOTH = 6
# Every so many columns are looked at.
_COLUMN_STEP = 4
# Mean height of the teeth that a motion between two frames must add, grey levels of 8 bit.
_MIN_MOTION = 0.02
# So much more motion than that settles the matter, and no further run is looked at.
_PLENTY = 5
# Where a progressive video has 0 and an interlaced one 1; see ``field_order``.
_WOVEN = 0.6


def may_be_interlaced(info: StreamInfo) -> bool:
    """Tell whether it is worth looking for interlacing that the stream does not declare."""
    rows = info.size[1]
    return 4 <= rows <= _MAX_ROWS and rows not in _PROGRESSIVE_ROWS and rows % 2 == 0


def field_order(runs: Iterable[Sequence[np.ndarray]], bits: int = 8) -> str | None:
    """Tell from luma which field of woven frames comes first, ``tff`` or ``bff``; None: not interlaced.

    ``runs`` are sequences of consecutive luma planes (h, w) of ``bits`` per sample. What moves grows comb
    teeth when two fields of different times are woven, the higher the farther apart. With the frame's own
    fields A teeth grow; with the next frame's upper field in place of its own B, and with the next frame's
    lower field C. In a progressive video A is at time distance 0, B and C at 2 fields. In an interlaced one
    A and one of B, C are at distance 1 and the other at 3. So (max - min) / (max - A), over B and C, is 0
    for a progressive and 1 for an interlaced video, and static detail drops out.
    """
    own = upper = lower = 0.0
    samples = 0
    threshold = _TOOTH << (bits - 8)
    enough = _MIN_MOTION * (1 << (bits - 8))
    signed = np.int16 if bits < 15 else np.int32  # holds the difference of two teeth
    for run in runs:
        thinned = [luma[:, ::_COLUMN_STEP].astype(signed) for luma in run]
        for now, then in pairwise(thinned):
            own += _teeth(now[0::2], now[1::2], threshold)
            upper += _teeth(then[0::2], now[1::2], threshold)
            lower += _teeth(now[0::2], then[1::2], threshold)
            samples += now.size // 2
        if max(upper, lower) - own > _PLENTY * enough * samples:
            break
    most, least = max(upper, lower), min(upper, lower)
    motion = most - own
    if samples == 0 or motion / samples < enough or (most - least) / motion < _WOVEN:
        return None
    return "tff" if upper < lower else "bff"


def _teeth(even: np.ndarray, odd: np.ndarray, threshold: int) -> float:
    """Sum the heights, above ``threshold``, by which odd rows stick out from the even rows on both sides."""
    rows = min(len(even) - 1, len(odd))
    row = odd[:rows]
    up, down = row - even[:rows], row - even[1 : rows + 1]
    # A tooth that points up is as high as the lower of its sides; one that points down goes by its negatives.
    upward = np.maximum(np.minimum(up, down), threshold)
    downward = np.minimum(np.maximum(up, down), -threshold)
    height = np.subtract(upward, downward, out=upward)
    return float(height.sum(dtype=np.int64)) - 2.0 * threshold * height.size


def time_base(info: StreamInfo, fields: bool) -> Fraction:
    """Return the time base of deinterlaced frames, fine enough for a time between two frames."""
    return info.time_base / 2 if fields else info.time_base


class Deinterlacer:
    """Turns woven frames into whole ones with bwdif.

    ``fields`` gives a frame for every field, at double the rate; otherwise one for every frame, at the
    frame's own time. ``order`` (``tff``, ``bff``) holds for all frames; without it each frame's flags
    tell, and ``only_flagged`` lets frames pass that are not flagged as interlaced. ``threads`` may work on
    a frame, 0 for as many as there are cores. ``frames`` counts the frames that were made whole.
    """

    def __init__(
        self,
        info: StreamInfo,
        *,
        fields: bool = False,
        order: str | None = None,
        only_flagged: bool = False,
        threads: int = 0,
    ) -> None:
        self._info = info
        self._threads = threads
        self._fields = fields
        self._only_flagged = only_flagged
        self._settings = ":".join(
            (
                f"mode={'send_field' if fields else 'send_frame'}",
                f"parity={order or 'auto'}",
                f"deint={'interlaced' if only_flagged else 'all'}",
            )
        )
        self.frames = 0

    @property
    def time_base(self) -> Fraction:
        """The time base of the frames that come out."""
        return time_base(self._info, self._fields)

    def apply(self, items: Iterable[Item]) -> Iterator[Item]:
        """Yield the items with their frames made whole; packets pass as they are.

        With ``only_flagged``, nothing is done before the first frame that is flagged.
        """
        graph: _Graph | None = None
        for item in items:
            if not is_frame(item):
                yield item
                continue
            flagged = bool(item.interlaced_frame)
            self.frames += flagged or not self._only_flagged
            if graph is None:
                if self._only_flagged and not flagged:
                    yield item
                    continue
                graph = _Graph(self._info, ("bwdif", self._settings), self._threads)
            yield from self._in_time(graph.push(item))
        if graph is not None:
            yield from self._in_time(graph.push(None))

    def _in_time(self, frames: Iterable[av.VideoFrame]) -> Iterator[av.VideoFrame]:
        """Put the filter's finer times back into ``time_base``."""
        for frame in frames:
            if frame.pts is not None and frame.time_base is not None:
                frame.pts = round(frame.pts * frame.time_base / self.time_base)
                frame.duration = round(frame.duration * frame.time_base / self.time_base)
            frame.time_base = self.time_base
            yield frame


class _Graph:
    """A filter that frames are pushed into and come out of in the format that they had."""

    def __init__(self, info: StreamInfo, stage: tuple[str, str], threads: int) -> None:
        self._graph = av.filter.Graph()
        self._graph.threads = threads
        source = self._graph.add_buffer(
            width=info.size[0],
            height=info.size[1],
            format=av.VideoFormat(info.pix_fmt),
            time_base=info.time_base,
        )
        back = self._graph.add("format", f"pix_fmts={info.pix_fmt}")
        sink = self._graph.add("buffersink")
        self._graph.link_nodes(source, self._graph.add(*stage), back, sink).configure()

    def push(self, frame: av.VideoFrame | None) -> Iterator[av.VideoFrame]:
        """Push a frame, or None at the end, and yield what comes out."""
        self._graph.vpush(frame)
        while True:
            try:
                yield self._graph.vpull()
            except (av.error.BlockingIOError, av.error.EOFError):
                return
