"""A video file out of pictures and sound that were made, not read."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction

import av
import av.container
import numpy as np
from av.video.reformatter import ColorRange, Colorspace
from numpy.typing import NDArray

from ..errors import OutputError, UsageError
from .access import reason

# Samples of sound that go to the encoder at once; AAC's own block.
_BLOCK = 1024


def compose(
    path: str,
    pictures: Iterable[NDArray[np.uint8]],
    size: tuple[int, int],
    rate: Fraction,
    sound: NDArray[np.float32] | None = None,
    sound_rate: int = 48000,
    crf: float = 18,
    name: str | None = None,
) -> int:
    """Encode pictures (uint8 (h, w, 3) BGR) as H.264 and ``sound`` (n,) as AAC; return the frame count.

    ``size`` is (width, height) in px, even numbers; ``rate`` is in frames per second; ``name`` is what
    messages call the file. BT.709, limited range, 4:2:0. One thread, no clock: the same pictures, if they
    are 112 px wide or more, give the same bytes. Raises OutputError where the file cannot be written,
    UsageError for a suffix that names no container.
    """
    if size[0] % 2 or size[1] % 2:
        raise UsageError(f"a clip of {size[0]}x{size[1]} px: width and height must be even")
    try:
        container = av.open("file:" + path, mode="w", options={"fflags": "+bitexact"})
    except ValueError as error:
        raise UsageError(
            f"{name or path}: the suffix names no known video format; use .mp4 or .mkv"
        ) from error
    try:
        with container:
            return _Composition(container, size, rate, sound, sound_rate, crf).write(pictures)
    except (av.error.FFmpegError, ValueError) as error:
        raise OutputError(f"{name or path}: cannot be written ({reason(error)})") from error


class _Composition:
    """The two streams of one file, written side by side."""

    def __init__(
        self,
        container: av.container.OutputContainer,
        size: tuple[int, int],
        rate: Fraction,
        sound: NDArray[np.float32] | None,
        sound_rate: int,
        crf: float,
    ) -> None:
        self._container = container
        self._rate = rate
        self._sound = sound
        self._played = 0
        self._video = container.add_stream(
            "libx264", rate=rate, options={"crf": f"{crf:g}", "preset": "medium", "threads": "1"}
        )
        context = self._video.codec_context
        context.width, context.height = size
        context.pix_fmt = "yuv420p"
        context.color_range, context.colorspace = 1, 1
        context.color_primaries, context.color_trc = 1, 1
        if sound is not None:
            self._audio = container.add_stream("aac", rate=sound_rate, layout="mono")

    def write(self, pictures: Iterable[NDArray[np.uint8]]) -> int:
        """Encode everything and return the number of frames."""
        count = 0
        for picture in pictures:
            frame = av.VideoFrame.from_ndarray(picture, "bgr24").reformat(
                format="yuv420p",
                dst_colorspace=Colorspace.ITU709,
                dst_color_range=ColorRange.MPEG,
            )
            frame.pts, frame.time_base = count, 1 / self._rate
            self._container.mux(self._video.encode(frame))
            count += 1
            self._play_until(count / self._rate)
        self._container.mux(self._video.encode(None))
        if self._sound is not None:
            self._container.mux(self._audio.encode(None))
        return count

    def _play_until(self, time: Fraction) -> None:
        """Encode the sound up to ``time``, s."""
        if self._sound is None:
            return
        rate = self._audio.codec_context.sample_rate
        until = min(len(self._sound), int(time * rate))
        while self._played < until:
            block = self._sound[self._played : min(self._played + _BLOCK, until)]
            frame = av.AudioFrame.from_ndarray(block[None, :], format="fltp", layout="mono")
            frame.sample_rate = rate
            frame.pts, frame.time_base = self._played, Fraction(1, rate)
            self._container.mux(self._audio.encode(frame))
            self._played += len(block)
