"""Reading a video: its frames in order, and the packets of all that goes along."""

from __future__ import annotations

import contextlib
import itertools
import math
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from types import TracebackType
from typing import Self, TypeGuard

import av
import av.container
from av.stream import Disposition

from ..errors import InputError
from .access import MAX_SIDE, Readable, open_input, reason
from .extent import is_cut_off
from .frames import workable_format
from .live import open_live
from .stream import StreamInfo, describe, descriptions, fourcc

# So many packets in a row that cannot be decoded, and nothing more is to be expected of the file.
MAX_CONSECUTIVE_FAILURES = 100

# A file that ends by so many seconds before its declared duration has been cut off.
_MISSING_S = 0.5
# AVFMT_FLAG_GENPTS
_GENERATE_TIMES = 0x0001
# Containers that hold no presentation times: what the library gives for them is a guess, and wrong where
# frames are stored in another order than they are shown in.
_WITHOUT_TIMES = frozenset(("avi", "h264", "hevc", "mpegvideo", "m4v", "mjpeg", "rawvideo"))
# Containers whose duration counts from time zero, not from their first frame.
_DURATION_FROM_ZERO = frozenset(("matroska,webm", "asf", "nut"))
# Containers, by the beginnings of their names, that describe all their streams at the start.
_WITH_HEADERS = ("mov,", "matroska,")

Item = av.VideoFrame | av.Packet


class VideoReader:
    """The first video stream of a file or pipe, decoded, with the other streams' packets beside it.

    ``info`` describes the video; ``others`` are the streams whose packets ``items`` hands through.
    ``damaged`` counts packets that could not be decoded, ``corrupt`` frames that were decoded with errors;
    ``truncated`` says that the file ended before its time. They are final when ``items`` has ended.
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
        self._live = live
        self._threads = threads
        self.decoded = 0
        self.damaged = 0
        self.corrupt = 0
        self.truncated = False
        self.hidden = 0
        self._end = -math.inf
        self._failures = 0
        self._source = source
        self._accepts = accepts
        self._allow_protocols = allow_protocols
        # Of packets in a container that gives no presentation time, and not yet come out as frames.
        self._decoding_times: deque[int] = deque()
        self._native: tuple[int, int, str] | None = None
        self._pix_fmt = ""
        if live and isinstance(source, str):
            self._container = open_live(source, name)
        else:
            self._container = open_input(source, name, allow_protocols)
        self._is_without_times = self._container.format.name in _WITHOUT_TIMES
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
            self._packets = self._demux()
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
        return None if self._is_without_times else self.info.frames

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
        if not isinstance(self._source, str) or self._live or self._is_without_times:
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
        if not isinstance(self._source, str) or self._live:
            return
        # What is to be known of the streams is known; but some containers tell of them only as they go.
        probe = not self._container.format.name.startswith(_WITH_HEADERS)
        with open_input(self._source, self.name, self._allow_protocols, probe) as container:
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
                    run = [
                        f for f in itertools.islice(decoded, frames) if _shape(f) == self._native
                    ]
                    yield run

    def from_start(self) -> Iterator[av.VideoFrame] | None:
        """Return the frames from the start once more, decoded anew beside ``items``; None for a pipe."""
        if not isinstance(self._source, str) or self._live:
            return None
        return self._again(self._source)

    def _again(self, source: str) -> Iterator[av.VideoFrame]:
        with VideoReader(
            source,
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
        packet = next(self._packets, None)
        if packet is None:
            return False
        if packet.stream_index != self._stream.index:
            self._primed.append(packet)
        else:
            self._primed.extend(self._settled(frame) for frame in self._decode(packet))
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
        elif self.declared is not None and self.decoded + self.hidden < self.declared:
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

    def _demux(self) -> Iterator[av.Packet]:
        """Yield packets; the dummy packets that end a stream only for the video, which they flush."""
        packets = self._container.demux()
        while True:
            try:
                packet = next(packets)
            except StopIteration:
                break
            except av.error.FFmpegError:
                # The container breaks off here, as a live one does in the end. What the decoder still holds
                # is worth having.
                self.truncated = not self._live
                yield self._flush_packet()
                return
            if packet.size == 0 and packet.dts is None:
                if packet.stream is self._stream:
                    yield self._flush_packet()
                continue
            self._note_time(packet)
            yield packet
        self.truncated = not self._live and self._ends_early()

    def _note_time(self, packet: av.Packet) -> None:
        time = packet.pts if packet.pts is not None else packet.dts
        if time is not None and packet.time_base:
            end = float((time + (packet.duration or 0)) * packet.time_base)
            self._end = max(self._end, end)

    def _ends_early(self) -> bool:
        """Tell whether the file lacks its end, or all streams end well before the container says."""
        container = self._container
        if isinstance(self._source, str) and (cut := is_cut_off(self._source)) is not None:
            # Times do not tell then: the last frame may be declared to be shown for long.
            return cut
        if not container.duration or self._end == -math.inf:
            return False
        start = 0 if container.format.name in _DURATION_FROM_ZERO else container.start_time or 0
        declared = (start + container.duration) / av.time_base
        rate = self._stream.average_rate
        if self._is_without_times and self._stream.frames and rate:
            # Its duration may be a guess from what is left of the file.
            declared = max(declared, float(self._stream.frames / rate))
        return declared - self._end > _MISSING_S

    def _flush_packet(self) -> av.Packet:
        packet = av.Packet()
        packet.stream = self._stream
        packet.time_base = self._stream.time_base or Fraction(1, av.time_base)
        return packet

    def _decode(self, packet: av.Packet) -> list[av.VideoFrame]:
        self.hidden += packet.is_discard
        if self._is_without_times and packet.dts is not None:
            self._decoding_times.append(packet.dts)
        try:
            frames = packet.decode()
        except av.error.EOFError:
            return []
        except av.error.FFmpegError as error:
            self.damaged += 1
            self._failures += 1
            if self._decoding_times:
                self._decoding_times.pop()
            if self._failures >= MAX_CONSECUTIVE_FAILURES:
                raise InputError(
                    f"{self.name}: {self._failures} packets in a row cannot be decoded ({reason(error)})"
                ) from error
            return []
        if frames:
            self._failures = 0
        return frames

    def _settled(self, frame: av.VideoFrame) -> av.VideoFrame:
        """Return the frame with its time and in the format to work in; InputError where it has changed."""
        self.decoded += 1
        self.corrupt += frame.is_corrupt
        if self._native is None:
            self._native = _shape(frame)
            self._pix_fmt = workable_format(frame.format, self._accepts)
        elif _shape(frame) != self._native:
            place = f"{frame.time:.3f} s" if frame.time is not None else "an unknown time"
            raise InputError(
                f"{self.name}: the frames change from {_described(self._native)} to"
                f" {_described(_shape(frame))} at {place}: split the file there"
            )
        pts = frame.pts
        if pts is None or self._is_without_times:
            pts = self._guessed_time()
        if self._pix_fmt != frame.format.name:
            frame = frame.reformat(format=self._pix_fmt)
        frame.pts = pts
        return frame

    def _guessed_time(self) -> int:
        """Give a frame the time that its container does not.

        Frames come out in the order of their times, and packets went in with the same times in the order of
        decoding; without even those, frames come at the stream's rate.
        """
        if self._decoding_times:
            return self._decoding_times.popleft()
        rate = self._stream.average_rate or self._stream.guessed_rate or 25
        return round(
            (self.decoded - 1) / rate / (self._stream.time_base or Fraction(1, av.time_base))
        )


def _counted(count: int, noun: str) -> str:
    return f"a {noun}" if count == 1 else f"{count} {noun}s"


def _is_shown_by(packet: av.Packet, run: Sequence[av.VideoFrame]) -> bool:
    """Tell whether a run of frames goes beyond the time of a packet's frame."""
    last = run[-1].pts if run else None
    return packet.pts is not None and last is not None and packet.pts <= last


def is_frame(item: Item) -> TypeGuard[av.VideoFrame]:
    """Tell a decoded frame from a packet."""
    return isinstance(item, av.VideoFrame)


def _shape(frame: av.VideoFrame) -> tuple[int, int, str]:
    return frame.width, frame.height, frame.format.name


def _described(shape: tuple[int, int, str]) -> str:
    return "{}x{} {}".format(*shape)
