"""Whole frames out of a video that may be interlaced, and what is said about it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

from ..video.frames import luma_bits, luma_view
from ..video.interlace import Deinterlacer, field_order, may_be_interlaced
from ..video.reader import Item, VideoReader
from ..video.stream import StreamInfo

_ORDER_NAMES = {"tff": "top field first", "bff": "bottom field first"}


class WholeFrames:
    """The items of a reader with its frames deinterlaced as ``mode`` asks: auto, off, frame or field.

    ``auto`` makes those frames whole that are flagged as interlaced, and all of them where they are combed
    without being flagged. ``info`` describes what comes out. ``threads``: see Deinterlacer.
    """

    def __init__(self, reader: VideoReader, mode: str, threads: int = 0) -> None:
        self.info = reader.info
        self._reader = reader
        self._mode = mode
        self._order = self._look() if mode != "off" or not reader.info.interlaced else None
        self._deinterlacer: Deinterlacer | None = None
        if mode != "off":
            self._deinterlacer = Deinterlacer(
                reader.info,
                fields=mode == "field",
                order=self._order,
                only_flagged=mode == "auto" and self._order is None,
                threads=threads,
            )
            self.info = self._described(self._deinterlacer)

    def items(self) -> Iterable[Item]:
        """Yield frames and packets in order."""
        items = self._reader.items()
        return items if self._deinterlacer is None else self._deinterlacer.apply(items)

    def frames_for(self, decoded: int) -> int:
        """Return how many frames come out of so many decoded ones."""
        return 2 * decoded if self._mode == "field" else decoded

    def notes(self) -> Iterator[str]:
        """Say what was done, once all items have been read."""
        what = f"combed, {_ORDER_NAMES[self._order]}" if self._order else "flagged as interlaced"
        if self._deinterlacer is None:
            if self._order or self.info.interlaced:
                yield f"the frames are {what}, and were remapped so: --deinterlace auto parts the fields"
        elif self._deinterlacer.frames and self._mode == "auto":
            yield f"{self._deinterlacer.frames} frames are {what}, and were deinterlaced"

    def _look(self) -> str | None:
        """Find the field order of combed frames; None where they are not combed, or say it themselves."""
        info = self._reader.info
        if info.interlaced or not may_be_interlaced(info):
            return None
        runs = ([luma_view(f) for f in run] for run in self._reader.samples())
        return field_order(runs, luma_bits(info.pix_fmt, info.bits))

    def _described(self, deinterlacer: Deinterlacer) -> StreamInfo:
        info = replace(self.info, time_base=deinterlacer.time_base, interlaced=False)
        if self._mode != "field":
            return info
        frames = None if info.frames is None else 2 * info.frames
        return replace(info, rate=2 * info.rate, frames=frames)
