"""Reading a video: its frames in order, and the packets of all that goes along."""

from __future__ import annotations

import contextlib
import itertools
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from types import TracebackType
from typing import Self, TypeGuard

import av
import av.container
from av.stream import Disposition

from ..errors import InputError
from .access import MAX_SIDE, Readable, open_input
from .decoder import Decoder
from .live import open_live
from .packets import Packets, is_without_times
from .stream import StreamInfo, describe, descriptions, fourcc

# AVFMT_FLAG_GENPTS
_GENERATE_TIMES = 0x0001
# Containers, by the beginnings of their names, that describe all their streams at the start.
_WITH_HEADERS = ("mov,", "matroska,")

Item = av.VideoFrame | av.Packet


class VideoReader:
    """The first video stream of a file or pipe, decoded, with the other streams' packets beside it.

    ``info`` describes the video; ``others`` are the streams whose packets ``items`` hands through.
    Raises InputError where there is no video, or none of it can be decoded.
    """

    def __init__(
        self,
        source: str | Readable,
        *,
        name: str,
        threads: int = 0,
        accepts: Callable[[str], bool] = lambda pix_fmt: True,
        allow_protocols: Sequence[str] = (),
        live: bool = False,
    ) -> None:
        self.name = name
        self._source = source
        # Where it can be read once more; no pipe and no live source can.
        self._path = source if isinstance(source, str) and not live else None
        self._threads = threads
        self._accepts = accepts
        self._allow_protocols = allow_protocols
        if live and isinstance(source, str):
            self._container = open_live(source, name)
        else:
            self._container = open_input(source, name, allow_protocols)
        # Made-up times of the library would pass for those of the file.
        self._container.flags &= ~_GENERATE_TIMES
        try:
            # Now, as long as no thread decodes, whose messages would be in the way.
            self._descriptions = descriptions(self._container)
            self._stream = self._choose_stream()
            context = self._stream.codec_context
            # Frames in threads come late by one for each thread.
            context.thread_type = "SLICE" if live else "AUTO"
            context.thread_count = threads
            guesses = is_without_times(self._container)
            self._packets = Packets(self._container, self._stream, self._path, live)
            self._decoder = Decoder(self._stream, name, accepts, guesses)
            self._primed: deque[Item] = deque()
            self.info = self._prime()
        except BaseException:
            self._container.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the file."""
        self._container.close()

    @property
    def container(self) -> av.container.InputContainer:
        """The open container, as the template for a writer's streams, chapters and metadata."""
        return self._container

    @property
    def stream(self) -> av.VideoStream:
        """The video stream that is decoded."""
        return self._stream

    @property
    def others(self) -> list[av.stream.Stream]:
        """All streams but the one that is decoded, and those that a writer makes anew from metadata."""
        chapters = len(self._container.chapters())

        def is_made_anew(stream: av.stream.Stream) -> bool:
            kind = fourcc(self._descriptions.get(stream.index, ""))
            if kind == "tmcd":
                return stream.type == "data" and "timecode" in self._stream.metadata
            # The titles of the chapters; beside a timecode some files do not say that it is that.
            is_titles = stream.type == "data" or stream.frames == chapters
            return kind == "text" and chapters > 0 and is_titles

        streams = self._container.streams
        return [s for s in streams if s.index != self._stream.index and not is_made_anew(s)]

    @property
    def declared(self) -> int | None:
        """The number of frames that the container declares; None where it does not, or counts gaps too."""
        return None if is_without_times(self._container) else self.info.frames

    @property
    def decoded(self) -> int:
        """How many frames have been decoded."""
        return self._decoder.decoded

    @property
    def damaged(self) -> int:
        """How many packets could not be decoded; final when ``items`` has ended."""
        return self._decoder.damaged

    @property
    def corrupt(self) -> int:
        """How many frames were decoded with errors; final when ``items`` has ended."""
        return self._decoder.corrupt

    @property
    def truncated(self) -> bool:
        """Whether the file ended before its time; final when ``items`` has ended."""
        return self._packets.truncated

    def items(self) -> Iterator[Item]:
        """Yield decoded frames in presentation order, and between them the other streams' packets.

        Raises InputError where the frame size or format changes, and after MAX_CONSECUTIVE_FAILURES.
        """
        while True:
            while self._primed:
                yield self._primed.popleft()
            if not self._advance():
                return

    def go_to(self, time: float) -> None:
        """Go on from the key frame before ``time``, s on the stream's clock; a pipe goes on where it is.

        Where the container cannot find the place, it goes on from the start.
        """
        if self._path is None or is_without_times(self._container):
            return
        with contextlib.suppress(av.error.FFmpegError):
            self._container.seek(round(max(time, self.info.start or 0) * av.time_base))
            self._stream.codec_context.flush_buffers()
            self._primed.clear()

    def samples(self, places: int = 3, frames: int = 6) -> Iterator[list[av.VideoFrame]]:
        """Yield runs of consecutive frames, from the start and, of a file, from key frames further on.

        Once the first run is taken, the others may be in another thread. Not all need be taken; ``items``
        still yields every frame.
        """
        run = self._look_ahead(frames)
        yield run
        if self._path is None:
            return
        # What is to be known of the streams is known; but some containers tell of them only as they go.
        probe = not self._container.format.name.startswith(_WITH_HEADERS)
        with open_input(self._path, self.name, self._allow_protocols, probe) as container:
            stream = container.streams[self._stream.index]
            assert isinstance(stream, av.VideoStream)
            stream.codec_context.thread_type = "AUTO"
            stream.codec_context.thread_count = self._threads
            for place in range(1, places):
                start = (self.info.start or 0) + (self.info.duration or 0) * place / places
                with contextlib.suppress(av.error.FFmpegError):
                    container.seek(round(start * av.time_base))
                    packets = container.demux(stream)
                    first = next(packets, None)
                    if first is None or _is_shown_by(first, run):
                        continue  # no key frame since the last run
                    decoded = (f for p in itertools.chain([first], packets) for f in p.decode())
                    run = list(filter(self._decoder.is_of_shape, itertools.islice(decoded, frames)))
                    yield run

    def from_start(self) -> Iterator[av.VideoFrame] | None:
        """Return the frames from the start once more, decoded anew beside ``items``; None for a pipe."""
        return None if self._path is None else self._again(self._path)

    def _again(self, path: str) -> Iterator[av.VideoFrame]:
        with VideoReader(
            path,
            name=self.name,
            threads=self._threads,
            accepts=self._accepts,
            allow_protocols=self._allow_protocols,
        ) as reader:
            yield from filter(is_frame, reader.items())

    def _look_ahead(self, count: int) -> list[av.VideoFrame]:
        """Decode on until ``count`` frames wait to be handed out, and return them."""
        while True:
            waiting = [item for item in self._primed if is_frame(item)]
            if len(waiting) >= count or not self._advance():
                return waiting

    def _advance(self) -> bool:
        """Read one packet and let wait what comes of it; False at the end of the file."""
        packet = self._packets.next()
        if packet is None:
            return False
        if packet.stream_index != self._stream.index:
            self._primed.append(packet)
        else:
            self._primed.extend(self._decoder.frames(packet))
        return True

    def _choose_stream(self) -> av.VideoStream:
        pictures = Disposition.attached_pic | Disposition.timed_thumbnails
        for stream in self._container.streams.video:
            if not stream.disposition & pictures:
                break
        else:
            raise InputError(f"{self.name}: holds no video stream")
        if stream.codec_context is None:
            raise InputError(f"{self.name}: no decoder is known for its video stream")
        if max(stream.width, stream.height) > MAX_SIDE:
            raise InputError(
                f"{self.name}: a frame of {stream.width}x{stream.height} is larger than {MAX_SIDE} px a side"
            )
        return stream

    def faults(self) -> Iterator[str]:
        """Say what was wrong with the input, once it has been read to its end."""
        if self.damaged:
            yield f"{_counted(self.damaged, 'damaged packet')} could not be decoded"
        if self.corrupt:
            was = "was" if self.corrupt == 1 else "were"
            yield f"{_counted(self.corrupt, 'frame')} {was} decoded with errors"
        if self.truncated:
            yield "the file breaks off before its end"
        elif self.declared is not None and self.decoded + self._decoder.hidden < self.declared:
            yield f"only {self.decoded} of the {self.declared} frames that it declares are there"

    def _prime(self) -> StreamInfo:
        """Decode up to the first frame, which alone knows its size, format and side data."""
        while self._advance():
            for item in self._primed:
                if is_frame(item):
                    return describe(self._container, self._stream, item, self._descriptions)
        why = ""
        if not isinstance(self._source, str) and "mp4" in self._container.format.name:
            why = ": an MP4 or MOV with its index at the end cannot flow through a pipe; name the file itself"
        raise InputError(f"{self.name}: no frame of its video stream can be decoded{why}")


def _counted(count: int, noun: str) -> str:
    return f"a {noun}" if count == 1 else f"{count} {noun}s"


def _is_shown_by(packet: av.Packet, run: Sequence[av.VideoFrame]) -> bool:
    """Tell whether a run of frames goes beyond the time of a packet's frame."""
    last = run[-1].pts if run else None
    return packet.pts is not None and last is not None and packet.pts <= last


def is_frame(item: Item) -> TypeGuard[av.VideoFrame]:
    """Tell a decoded frame from a packet."""
    return isinstance(item, av.VideoFrame)
