"""Reading a video: its frames in order, and the packets of all that goes along."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from fractions import Fraction
from types import TracebackType
from typing import Self, TypeGuard

import av
import av.container
from av.stream import Disposition

from ..errors import InputError
from .access import MAX_SIDE, Readable, open_input, reason
from .stream import StreamInfo, describe

# So many packets in a row that cannot be decoded, and nothing more is to be expected of the file.
MAX_CONSECUTIVE_FAILURES = 100

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
        allow_protocols: Sequence[str] = (),
    ) -> None:
        self.name = name
        self.damaged = 0
        self.corrupt = 0
        self.truncated = False
        self._failures = 0
        self._container = open_input(source, name, allow_protocols)
        try:
            self._stream = self._choose_stream()
            context = self._stream.codec_context
            context.thread_type = "AUTO"
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
        """All streams but the one that is decoded."""
        return [s for s in self._container.streams if s.index != self._stream.index]

    def items(self) -> Iterator[Item]:
        """Yield decoded frames in presentation order, and between them the other streams' packets.

        Raises InputError where the frame size or format changes, and after MAX_CONSECUTIVE_FAILURES.
        """
        while self._primed:
            yield self._primed.popleft()
        for packet in self._packets:
            if packet.stream_index != self._stream.index:
                yield packet
                continue
            for frame in self._decode(packet):
                self._check_frame(frame)
                yield frame

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

    def _prime(self) -> StreamInfo:
        """Decode up to the first frame, which alone knows its size, format and side data."""
        for packet in self._packets:
            if packet.stream_index != self._stream.index:
                self._primed.append(packet)
                continue
            frames = self._decode(packet)
            if frames:
                info = describe(self._container, self._stream, frames[0])
                self.info = info
                for frame in frames:
                    self._check_frame(frame)
                self._primed.extend(frames)
                return info
        raise InputError(f"{self.name}: no frame of its video stream can be decoded")

    def _demux(self) -> Iterator[av.Packet]:
        """Yield packets; the dummy packets that end a stream only for the video, which they flush."""
        packets = self._container.demux()
        while True:
            try:
                packet = next(packets)
            except StopIteration:
                return
            except av.error.FFmpegError:
                # The container breaks off here. What the decoder still holds is worth having.
                self.truncated = True
                yield self._flush_packet()
                return
            if packet.size == 0 and packet.dts is None:
                if packet.stream is self._stream:
                    yield self._flush_packet()
                continue
            yield packet

    def _flush_packet(self) -> av.Packet:
        packet = av.Packet()
        packet.stream = self._stream
        packet.time_base = self._stream.time_base or Fraction(1, av.time_base)
        return packet

    def _decode(self, packet: av.Packet) -> list[av.VideoFrame]:
        try:
            frames = packet.decode()
        except av.error.EOFError:
            return []
        except av.error.FFmpegError as error:
            self.damaged += 1
            self._failures += 1
            if self._failures >= MAX_CONSECUTIVE_FAILURES:
                raise InputError(
                    f"{self.name}: {self._failures} packets in a row cannot be decoded ({reason(error)})"
                ) from error
            return []
        if frames:
            self._failures = 0
        return frames

    def _check_frame(self, frame: av.VideoFrame) -> None:
        if frame.is_corrupt:
            self.corrupt += 1
        if frame.pts is None:
            frame.pts = frame.dts
        size = (frame.width, frame.height)
        if size != self.info.size or frame.format.name != self.info.pix_fmt:
            place = f"{frame.time:.3f} s" if frame.time is not None else "an unknown time"
            w, h = self.info.size
            raise InputError(
                f"{self.name}: the frames change from {w}x{h} {self.info.pix_fmt} to"
                f" {frame.width}x{frame.height} {frame.format.name} at {place}; split the file there"
            )


def is_frame(item: Item) -> TypeGuard[av.VideoFrame]:
    """Tell a decoded frame from a packet."""
    return isinstance(item, av.VideoFrame)
