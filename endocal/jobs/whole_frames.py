"""Whole frames out of a video that may be interlaced, and what is said about it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from itertools import chain

from ..video.frames import luma_bits, luma_view
from ..video.interlace import Deinterlacer, field_order, may_be_interlaced, time_base
from ..video.reader import Item, VideoReader
from .background import Background

_ORDER_NAMES = {"tff": "top field first", "bff": "bottom field first"}


class WholeFrames:
    """The items of a reader with its frames deinterlaced as ``mode`` asks: auto, off, frame or field.

    ``auto`` makes those frames whole that are flagged as interlaced, and all of them where they are combed
    without being flagged. ``info`` describes what comes out. ``threads``: see Deinterlacer. Combs are looked
    for while the caller prepares the rest.
    """

    def __init__(self, reader: VideoReader, mode: str, threads: int = 0) -> None:
        self.info = reader.info
        self._reader = reader
        self._mode = mode
        self._threads = threads
        self._looking = self._look() if mode != "off" or not reader.info.interlaced else None
        self._deinterlacer: Deinterlacer | None = None
        if mode == "field":
            frames = None if self.info.frames is None else 2 * self.info.frames
            self.info = replace(self.info, rate=2 * self.info.rate, frames=frames)
        if mode != "off":
            base = time_base(reader.info, fields=mode == "field")
            self.info = replace(self.info, time_base=base, interlaced=False)

    @cached_property
    def _order(self) -> str | None:
        """The field order of frames that are combed and do not say so."""
        return None if self._looking is None else self._looking.result()

    def items(self) -> Iterator[Item]:
        """Yield frames and packets in order."""
        order = self._order
        if self._mode == "off":
            yield from self._reader.items()
            return
        self._deinterlacer = Deinterlacer(
            self._reader.info,
            fields=self._mode == "field",
            order=order,
            only_flagged=self._mode == "auto" and order is None,
            threads=self._threads,
        )
        yield from self._deinterlacer.apply(self._reader.items())

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

    def _look(self) -> Background[str | None] | None:
        """Begin to look for the field order; None where the frames are not combed, or say it themselves."""
        info = self._reader.info
        if info.interlaced or not may_be_interlaced(info):
            return None
        samples = self._reader.samples()
        # The first ones are the reader's next frames; the others are decoded apart.
        runs = chain([next(samples)], samples)
        lumas = ([luma_view(f) for f in run] for run in runs)
        return Background(lambda: field_order(lumas, luma_bits(info.pix_fmt, info.bits)))
