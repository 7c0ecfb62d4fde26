"""Frames from a video stream's packets: each with its time, in a format to work in, and all of one shape."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from fractions import Fraction

import av

from ..errors import InputError
from .access import reason
from .frames import workable_format

# So many packets in a row that cannot be decoded, and nothing more is to be expected of the file.
MAX_CONSECUTIVE_FAILURES = 100


class Decoder:
    """The decoder of ``stream``, which gives frames in a pixel format that ``accepts`` takes.

    ``decoded`` counts frames, ``damaged`` packets that could not be decoded, ``corrupt`` frames that were
    decoded with errors, ``hidden`` packets that an edit list leaves out. ``guesses_times`` is for containers
    that hold no presentation times.
    """

    def __init__(
        self,
        stream: av.VideoStream,
        name: str,
        accepts: Callable[[str], bool],
        guesses_times: bool,
    ) -> None:
        self.decoded = 0
        self.damaged = 0
        self.corrupt = 0
        self.hidden = 0
        self._stream = stream
        self._name = name
        self._accepts = accepts
        self._guesses_times = guesses_times
        # Of packets in a container that gives no presentation time, and not yet come out as frames.
        self._decoding_times: deque[int] = deque()
        self._failures = 0
        self._shape: tuple[int, int, str] | None = None
        self._pix_fmt = ""

    def frames(self, packet: av.Packet) -> Iterator[av.VideoFrame]:
        """Return the frames that come out as ``packet`` goes in.

        Raises InputError where their size or format changes, and after MAX_CONSECUTIVE_FAILURES.
        """
        return map(self._settled, self._decode(packet))

    def is_of_shape(self, frame: av.VideoFrame) -> bool:
        """Tell whether a frame has the size and the format that all frames have had so far."""
        return _shape(frame) == self._shape

    def _decode(self, packet: av.Packet) -> list[av.VideoFrame]:
        self.hidden += packet.is_discard
        if self._guesses_times and packet.dts is not None:
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
                    f"{self._name}: {self._failures} packets in a row cannot be decoded ({reason(error)})"
                ) from error
            return []
        if frames:
            self._failures = 0
        return frames

    def _settled(self, frame: av.VideoFrame) -> av.VideoFrame:
        """Return the frame with its time and in the format to work in; InputError where it has changed."""
        self.decoded += 1
        self.corrupt += frame.is_corrupt
        if self._shape is None:
            self._shape = _shape(frame)
            self._pix_fmt = workable_format(frame.format, self._accepts)
        elif not self.is_of_shape(frame):
            place = f"{frame.time:.3f} s" if frame.time is not None else "an unknown time"
            raise InputError(
                f"{self._name}: the frames change from {_described(self._shape)} to"
                f" {_described(_shape(frame))} at {place}: split the file there"
            )
        pts = frame.pts
        if pts is None or self._guesses_times:
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


def _shape(frame: av.VideoFrame) -> tuple[int, int, str]:
    return frame.width, frame.height, frame.format.name


def _described(shape: tuple[int, int, str]) -> str:
    return "{}x{} {}".format(*shape)
