"""Writing a video beside the streams, chapters and metadata that it came with."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import NoReturn, Protocol, Self

import av
import av.container
import av.stream

from ..errors import OutputError, UsageError
from .access import reason
from .container import ContainerKind
from .copies import Copies
from .encoder import EncoderChoice, settle
from .frames import FramePool
from .opening import open_encoder
from .reader import Item, VideoReader
from .stream import StreamInfo
from .suffix import check_named
from .verify import verify_video

# The container flag by which every packet is passed on at once.
_FLUSH_PACKETS = 0x0200
# FFmpeg's numbers for the colour range: unspecified, limited, full.
_RANGES = {None: 0, False: 1, True: 2}
# A frame that moves by less has not moved, s.
_UNSEEN_S = 0.001


@dataclass(frozen=True)
class OutputPicture:
    """What the frames to be written look like: (width, height), pixel format and pixel aspect ratio.

    ``size_asked`` says that the size is the user's own choice.
    """

    size: tuple[int, int]
    pix_fmt: str
    sample_aspect: Fraction | None
    size_asked: bool = False


class Writable(Protocol):
    """What a pipe takes: bytes, from front to end."""

    def write(self, data: bytes) -> int:
        """Write all of the bytes."""
        ...


class VideoWriter:
    """Encodes frames and copies packets into one file or pipe.

    The frames have the source's time stamps and colour; ``frame()`` hands out frames to fill and ``write``
    takes them, and the other streams' packets, in the order in which the reader gave them. ``info`` is the
    source's, with its rate and time base as they come out. ``name`` is what messages call the output;
    ``notes`` says in plain words what could not be kept, once it is finished; ``frames`` counts those
    written.
    Raises OutputError where the container or the encoder refuses.
    """

    def __init__(
        self,
        target: str | Writable,
        like: VideoReader,
        info: StreamInfo,
        picture: OutputPicture,
        choice: EncoderChoice,
        *,
        name: str,
        container_format: str | None = None,
        strip_metadata: bool = False,
    ) -> None:
        self.name = name
        self.notes: list[str] = []
        self.frames = 0
        self._packets = 0
        self._handed_out = -1
        self._first_pts: int | None = None
        self._last_pts: int | None = None
        self._moved = 0.0
        self._path = target if isinstance(target, str) else None
        self._info = info
        self._pool = FramePool(picture.size, picture.pix_fmt)
        self._lock = threading.Lock()
        self._container = self._open(target, container_format)
        if not isinstance(target, str):
            # Whoever reads the pipe gets each packet when it is there.
            self._container.flags |= _FLUSH_PACKETS
        self._kind = ContainerKind(self._container.format.name)
        self._time_base = 1 / info.rate if self._kind.counts_frames else info.time_base
        try:
            self._add_video(picture, choice)
            self._stream.disposition = like.stream.disposition
            self._copies = Copies(self._container, self._kind, like, strip_metadata)
            self._copies.copy_tags(self._stream)
            self.notes += self._copies.notes
            self._container.container_options.update(
                self._kind.options(
                    self._time_base,
                    self._container.metadata,
                    flows=not isinstance(target, str),
                )
            )
            self._guard(self._container.start_encoding)
        except BaseException:
            self._abandon()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if error is None:
            self.finish()
        else:
            self._abandon()

    @property
    def dropped(self) -> int:
        """How many damaged packets of other streams were left out, as no container takes them."""
        return self._copies.dropped

    @property
    def codec(self) -> str:
        """The encoder's name."""
        return self._stream.codec_context.codec.name

    def frame(self, source: av.VideoFrame) -> av.VideoFrame:
        """Return a frame to fill, with the time stamp and colour of ``source``."""
        frame = self._pool.take()
        self._handed_out += 1
        if self._first_pts is None:
            self._first_pts = source.pts
        frame.pts = source.pts
        if self._kind.counts_frames and source.pts is not None and self._first_pts is not None:
            # Such a file begins at zero whatever the source did, and each frame is due at its number.
            seconds = (source.pts - self._first_pts) * self._info.time_base
            due = round(seconds / self._time_base)
            frame.pts = due if self._kind.holds_gaps else self._handed_out
            self._moved = max(self._moved, abs(float(seconds - frame.pts * self._time_base)))
        frame.time_base = self._time_base
        frame.duration = round(source.duration * self._info.time_base / self._time_base)
        colour = self._info.colour
        frame.color_range = _RANGES[colour.full_range]
        frame.colorspace = colour.matrix
        frame.color_primaries = colour.primaries
        frame.color_trc = colour.transfer
        return frame

    def write(self, item: Item) -> None:
        """Encode a frame from ``frame()``, or copy a packet of another stream."""
        with self._lock:
            if isinstance(item, av.Packet):
                self._guard(partial(self._copies.write, item))
            else:
                self._encode(item)

    def _encode(self, item: av.VideoFrame) -> None:
        if self._last_pts is not None and (item.pts is None or item.pts <= self._last_pts):
            # Only a damaged file repeats a time; an encoder needs them to increase.
            item.pts = self._last_pts + 1
        self._last_pts = item.pts
        self._mux(self._guard(lambda: self._stream.encode(item)))
        self.frames += 1
        self._pool.give_back(item)

    def finish(self) -> None:
        """Flush the encoder, close the file, and check that every frame went in.

        Raises OutputError where a frame is missing or the file cannot be completed.
        """
        try:
            self._mux(self._guard(lambda: self._stream.encode(None)))
        except BaseException:
            self._abandon()
            raise
        self._guard(self._container.close)
        if self._packets != self.frames:
            raise OutputError(
                f"{self.name}: {self.frames} frames were encoded but {self._packets} came out"
            )
        if self._moved > _UNSEEN_S:
            self.notes.append(
                f"{self._kind.shown} holds no times but a constant rate: frames moved by up to"
                f" {self._moved:.3f} s; .mp4 and .mkv keep the times"
            )
        if self._path is not None and self._kind.describes_itself:
            # Where frames are counted, a gap is a frame too, and the duration follows from the count.
            exact = not self._kind.counts_frames
            verify_video(self._path, self.name, self.frames, self._seconds() if exact else None)

    def _seconds(self) -> float | None:
        """The time from the first frame's start to the last one's end."""
        if self._first_pts is None or self._last_pts is None:
            return None
        return float((self._last_pts - self._first_pts) * self._time_base + 1 / self._info.rate)

    def _abandon(self) -> None:
        """Close the file as it is; what is in it is of no use to anyone."""
        # A thread that hangs in a write, to a pipe that nobody reads, keeps the file.
        if not self._lock.acquire(timeout=1):
            return
        with contextlib.suppress(av.error.FFmpegError, OSError, ValueError):
            self._container.close()
        self._lock.release()

    def _guard(self, action: Callable[[], list[av.Packet] | None]) -> list[av.Packet]:
        try:
            return action() or []
        except (av.error.FFmpegError, ValueError, OSError) as error:
            self._refuse(error)

    def _refuse(self, error: Exception) -> NoReturn:
        """Raise what a failed write means: a reader of the pipe that has gone is for the caller to judge."""
        if isinstance(error, BrokenPipeError):
            raise error
        why = reason(error)
        if isinstance(error, av.error.ArgumentError) and self._kind.holds_gaps:
            why += f": a gap in the recording may be too long for {self._kind.shown}; .mp4 and .mkv hold it"
        raise OutputError(f"{self.name}: cannot be written ({why})") from error

    def _open(
        self, target: str | Writable, container_format: str | None
    ) -> av.container.OutputContainer:
        what = "its suffix" if container_format is None else f"--format {container_format}"
        refusal = UsageError(
            f"{self.name}: {what} names no video file; use one such as .mp4, .mkv, .mov or .avi"
        )
        try:
            container = av.open(
                "file:" + target if isinstance(target, str) else target,
                mode="w",
                format=container_format,
                buffer_size=1 << 20,
            )
        except ValueError as error:
            raise refusal from error
        except av.error.FFmpegError as error:
            raise OutputError(f"{self.name}: cannot be written ({reason(error)})") from error
        if container.format.no_file:
            # Numbered pictures, playlists with their segments, devices: files of their own choosing.
            raise refusal
        if self._path is not None and container_format is not None:
            check_named(Path(self._path).suffix, container.format.name, self.name)
        return container

    def _add_video(self, picture: OutputPicture, choice: EncoderChoice) -> None:
        info = self._info
        settings = settle(choice, info, self._kind)
        options = dict(settings.options)
        if info.colour.chroma_location:
            options["chroma_sample_location"] = info.colour.chroma_location
        options.setdefault("field_order", "progressive")
        stream = self._container.add_stream(settings.codec, rate=info.rate, options=options)
        assert isinstance(stream, av.VideoStream)
        context = stream.codec_context
        context.width, context.height = picture.size
        context.pix_fmt = settings.pix_fmt
        context.time_base = self._time_base
        stream.time_base = self._time_base
        if picture.sample_aspect is not None:
            context.sample_aspect_ratio = picture.sample_aspect
        context.color_range = _RANGES[info.colour.full_range]
        context.colorspace = info.colour.matrix
        context.color_primaries = info.colour.primaries
        context.color_trc = info.colour.transfer
        # Frames in threads, which is quicker and compresses better than slices in threads.
        context.thread_type = "AUTO"
        context.thread_count = choice.threads
        if info.display_matrix is not None:
            stream.set_display_matrix(info.display_matrix)
        self._stream = stream
        open_encoder(context, choice, self.name, picture.size_asked)

    def _mux(self, packets: list[av.Packet]) -> None:
        for packet in packets:
            if packet.stream is self._stream or packet.stream_index == self._stream.index:
                self._packets += 1
            self._guard(partial(self._container.mux_one, packet))
