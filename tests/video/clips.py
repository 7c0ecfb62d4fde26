"""Small clips made on the spot, with everything in them that a recording may have."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import av.filter
import numpy as np

Picture = Callable[[int, int, int], np.ndarray]


def drifting(number: int, width: int, height: int) -> np.ndarray:
    """A smooth pattern that moves to the right and grows brighter: uint8 (h, w, 3) RGB."""
    x, y = np.meshgrid(np.arange(width), np.arange(height))
    wave = np.sin((x - 3 * number) / 9) * np.cos(y / 7)
    base = 110 + 60 * wave + number
    return np.stack([base, base * 0.9 + 8, 200 - base * 0.5], axis=-1).clip(0, 255).astype(np.uint8)


@dataclass
class Clip:
    """What to make; ``pts`` counts in ``time_base``, by default one frame after the other."""

    frames: int = 12
    size: tuple[int, int] = (64, 48)
    rate: Fraction = Fraction(25)
    codec: str = "ffv1"
    pix_fmt: str = "yuv420p"
    options: dict[str, str] = field(default_factory=dict)
    time_base: Fraction | None = None
    pts: Sequence[int] | None = None
    sample_aspect: Fraction | None = None
    # (range, matrix, primaries, transfer) by FFmpeg's numbers
    colour: tuple[int, int, int, int] = (0, 2, 2, 2)
    sounds: Sequence[str] = ()  # a language for each sound track
    subtitles: bool = False
    attachment: bytes | None = None
    metadata: dict[str, str] = field(default_factory=dict)
    chapters: Sequence[tuple[float, float, str]] = ()
    display_matrix: Sequence[int] | None = None
    picture: Picture = drifting
    interlace: str = ""  # tff or bff: weave pairs of pictures

    def make(self, path: Path, container_format: str | None = None, **options: str) -> Path:
        """Write the clip and return its path."""
        with av.open(str(path), "w", format=container_format, container_options=options) as out:
            Maker(self, out).run()
        return path


class Maker:
    """Fills a container with a clip."""

    def __init__(self, clip: Clip, out: Any) -> None:
        self.clip, self.out = clip, out
        self.video = out.add_stream(clip.codec, rate=clip.rate, options=dict(clip.options))
        context = self.video.codec_context
        context.width, context.height = clip.size
        context.pix_fmt = clip.pix_fmt
        context.thread_count = 1
        if clip.time_base is not None:
            context.time_base = self.video.time_base = clip.time_base
        if clip.sample_aspect is not None:
            context.sample_aspect_ratio = clip.sample_aspect
        context.color_range, context.colorspace = clip.colour[:2]
        context.color_primaries, context.color_trc = clip.colour[2:]
        if clip.display_matrix is not None:
            self.video.set_display_matrix(clip.display_matrix)
        self.sounds = []
        for language in clip.sounds:
            sound = out.add_stream("aac", rate=48000, layout="mono")
            sound.metadata["language"] = language
            self.sounds.append(sound)
        self.text = out.add_mux_stream("subrip") if clip.subtitles else None
        if clip.attachment is not None:
            out.add_attachment("note.txt", "text/plain", clip.attachment)
        out.metadata.update(clip.metadata)
        if clip.chapters:
            out.set_chapters(
                [
                    {
                        "id": i + 1,
                        "start": int(start * 1000),
                        "end": int(end * 1000),
                        "time_base": Fraction(1, 1000),
                        "metadata": {"title": title},
                    }
                    for i, (start, end, title) in enumerate(clip.chapters)
                ]
            )

    def run(self) -> None:
        for frame in self.pictures():
            self.out.mux(self.video.encode(frame))
        self.out.mux(self.video.encode(None))
        for number, sound in enumerate(self.sounds):
            self.play(sound, number)
        if self.text is not None:
            self.write_text()

    def pictures(self) -> list[av.VideoFrame]:
        clip = self.clip
        made = []
        for i in range(clip.frames):
            if clip.interlace:
                first, second = (clip.picture(2 * i + k, *clip.size) for k in (0, 1))
                upper, lower = (first, second) if clip.interlace == "tff" else (second, first)
                picture = upper.copy()
                picture[1::2] = lower[1::2]
            else:
                picture = clip.picture(i, *clip.size)
            frame = av.VideoFrame.from_ndarray(picture, "rgb24").reformat(format=clip.pix_fmt)
            frame.pts = i if clip.pts is None else clip.pts[i]
            frame.time_base = clip.time_base or 1 / clip.rate
            if clip.pts is None and clip.time_base is not None:
                frame.pts = round(i / clip.rate / clip.time_base)
            frame.color_range, frame.colorspace = clip.colour[:2]
            made.append(frame)
        return made

    def play(self, stream: Any, number: int) -> None:
        length = int(48000 * self.clip.frames / self.clip.rate)
        tone = 0.2 * np.sin(np.arange(length) * 0.05 * (number + 1), dtype=np.float32)
        for start in range(0, length, 1024):
            block = tone[None, start : start + 1024].astype(np.float32)
            frame = av.AudioFrame.from_ndarray(block, format="fltp", layout="mono")
            frame.sample_rate, frame.pts, frame.time_base = 48000, start, Fraction(1, 48000)
            self.out.mux(stream.encode(frame))
        self.out.mux(stream.encode(None))

    def write_text(self) -> None:
        packet = av.Packet(b"Hello")
        packet.stream = self.text
        packet.time_base = Fraction(1, 1000)
        packet.pts = packet.dts = 40
        packet.duration = 200
        self.out.mux(packet)


@dataclass(frozen=True)
class Contents:
    """What a file holds: its frames, and the packets of each other stream with their times in s."""

    frames: list[av.VideoFrame]
    times: list[float]
    packets: dict[int, list[tuple[float, bytes]]]
    types: list[str]
    languages: list[str | None]
    metadata: dict[str, str]
    chapters: list[tuple[float, float, str]]


def contents(path: Path, container_format: str | None = None) -> Contents:
    """Read all of a file."""
    with av.open(str(path), format=container_format) as file:
        video = file.streams.video[0]
        frames: list[av.VideoFrame] = []
        packets: dict[int, list[tuple[float, bytes]]] = {
            s.index: [] for s in file.streams if s.index != video.index
        }
        for packet in file.demux():
            if packet.stream is video:
                frames += packet.decode()
            elif packet.size:
                packets[packet.stream_index].append(
                    (float(packet.pts * packet.time_base), bytes(packet))
                )
        return Contents(
            frames=frames,
            times=[f.time for f in frames],
            packets=packets,
            types=[s.type for s in file.streams],
            languages=[s.language for s in file.streams],
            metadata=dict(file.metadata),
            chapters=[
                (
                    float(c["start"] * c["time_base"]),
                    float(c["end"] * c["time_base"]),
                    c["metadata"].get("title", ""),
                )
                for c in file.chapters()
            ],
        )
