"""The visible circle in each frame of a video or in a picture: the job behind ``endocal boundary``."""

from __future__ import annotations

import contextlib
import time
from array import array
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from ..boundary.circle import Boundary
from ..boundary.detect import Located, locate_boundary
from ..errors import UsageError
from ..files import atomic_output, decode_image, encode_image, read_image
from ..files.images import PICTURE_SUFFIXES
from ..files.names import shown
from ..video.encoder import EncoderChoice
from ..video.frames import has_luma_plane, plane_views
from ..video.pipeline import run
from ..video.reader import Item, VideoReader, is_frame
from ..video.writer import OutputPicture, VideoWriter
from .correct import holds_picture
from .correction import Progress
from .pipe import PIPE, PipeInput


@dataclass(frozen=True)
class BoundaryJob:
    """Where to look for the circle.

    ``input`` is a path or ``-``; ``overlay`` a path for the same with the circle drawn in. ``pixel_aspect``
    (a pixel's width over its height) overrides what a video says; a picture says nothing.
    """

    input: str
    overlay: str | None = None
    pixel_aspect: float | None = None
    overwrite: bool = False
    allow_protocols: tuple[str, ...] = ()


@dataclass(frozen=True)
class FrameBoundary:
    """The circle of one frame, or None; ``time`` in s is None for a picture."""

    frame: int
    time: float | None
    located: Located | None

    def data(self) -> dict[str, Any]:
        """Return it as plain data, rounded below what can be measured.

        ``uncertainty`` has one standard deviation of the diameter, that of a rim that is no perfect circle
        included, and of the centre from frame to frame; px of the frame's height.
        """
        circle = None
        if self.located is not None:
            b = self.located.boundary
            circle = {
                "center": [round(v, 3) for v in b.center],
                "diameter": round(b.diameter, 3),
                "area": round(b.area),
                "visible": round(b.visible, 4),
                "uncertainty": {
                    "diameter": round(self.located.uncertainty, 3),
                    "center": round(self.located.center_sigma, 3),
                },
            }
        seconds = None if self.time is None else round(self.time, 6)
        return {"frame": self.frame, "time": seconds, "boundary": circle}


@dataclass(frozen=True)
class BoundaryReport:
    """How many frames there were and how many showed a circle, with the median and range of its diameter.

    ``input`` is what messages call it, ``warnings`` say what was wrong with it.
    """

    input: str
    warnings: tuple[str, ...]
    frames: int
    found: int
    diameter: float | None
    narrowest: float | None
    widest: float | None


def find_boundaries(
    job: BoundaryJob,
    emit: Callable[[FrameBoundary], None],
    progress: Callable[[Progress], None] | None = None,
) -> BoundaryReport:
    """Find the circle in every frame and hand it to ``emit`` in order.

    In a video it is looked for first where it was a frame before.

    Raises InputError for an input that is no picture or video, OutputError for the overlay.
    """
    source = PipeInput() if job.input == PIPE else job.input
    frames = 0
    diameters = array("d")
    name = "stdin" if job.input == PIPE else shown(job.input)
    warnings: tuple[str, ...] = ()

    def take(found: FrameBoundary) -> None:
        nonlocal frames
        frames += 1
        if found.located is not None:
            diameters.append(found.located.boundary.diameter)
        emit(found)

    if holds_picture(source):
        _picture(job, name, source, take)
    else:
        warnings = _video(job, name, source, take, progress)
    if not diameters:
        return BoundaryReport(name, warnings, frames, 0, None, None, None)
    middle = float(np.median(diameters))
    least, most = min(diameters), max(diameters)
    return BoundaryReport(name, warnings, frames, len(diameters), middle, least, most)


def _picture(
    job: BoundaryJob, name: str, source: str | PipeInput, take: Callable[[FrameBoundary], None]
) -> None:
    if job.overlay is not None and Path(job.overlay).suffix.lower() not in PICTURE_SUFFIXES:
        raise UsageError(
            f"{shown(job.overlay)}: a picture is written as {', '.join(PICTURE_SUFFIXES)}"
        )
    if isinstance(source, PipeInput):
        image, inputs = decode_image(source.read(), name), []
    else:
        image, inputs = read_image(source), [source]
    aspect = job.pixel_aspect or 1.0
    located = locate_boundary(image, aspect)
    if job.overlay is not None:
        if located is not None:
            image = image.copy()
            white = 255 if image.dtype == np.uint8 else 65535
            draw_boundary(image, located.boundary, aspect, white)
        data = encode_image(image, Path(job.overlay).suffix)
        with atomic_output(job.overlay, overwrite=job.overwrite, inputs=inputs) as path:
            path.write_bytes(data)
    take(FrameBoundary(0, None, located))


def _video(
    job: BoundaryJob,
    name: str,
    source: str | PipeInput,
    take: Callable[[FrameBoundary], None],
    progress: Callable[[Progress], None] | None,
) -> tuple[str, ...]:
    """Look through a video; returns what was wrong with it."""
    began = time.monotonic()
    frames = 0
    last: Boundary | None = None
    with VideoReader(
        source,
        name=name,
        accepts=has_luma_plane,
        allow_protocols=job.allow_protocols,
    ) as reader:
        info = reader.info
        aspect = job.pixel_aspect or float(info.sample_aspect or 1)
        white = (255 if info.full_range else 235) << (info.bits - 8)

        def look(item: Item) -> Boundary | None:
            nonlocal frames, last
            assert is_frame(item)
            located = locate_boundary(plane_views(item)[0], aspect, guess=last)
            last = None if located is None else located.boundary
            take(FrameBoundary(frames, item.time, located))
            frames += 1
            return last

        def tick() -> None:
            if progress is not None:
                progress(Progress(frames, info.frames, time.monotonic() - began))

        if job.overlay is None:
            for item in reader.items():
                if is_frame(item):
                    look(item)
                    tick()
            return tuple(reader.faults())
        with _overlay_writer(job, reader) as writer:

            def change(item: Item) -> Item:
                if not is_frame(item):
                    return item
                boundary = look(item)
                out = writer.frame(item)
                planes = plane_views(out)
                for to, plane in zip(planes, plane_views(item), strict=True):
                    to[...] = plane
                if boundary is not None:
                    draw_boundary(planes[0], boundary, aspect, white)
                return out

            run(reader.items(), change, writer.write, is_large=is_frame, tick=tick)
        return tuple(reader.faults())


@contextlib.contextmanager
def _overlay_writer(job: BoundaryJob, reader: VideoReader) -> Iterator[VideoWriter]:
    assert job.overlay is not None
    info = reader.info
    inputs = [] if job.input == PIPE else [job.input]
    picture = OutputPicture(info.size, info.pix_fmt, info.sample_aspect)
    with (
        atomic_output(job.overlay, overwrite=job.overwrite, inputs=inputs) as path,
        VideoWriter(
            str(path), reader, info, picture, EncoderChoice(), name=shown(job.overlay)
        ) as writer,
    ):
        yield writer


def draw_boundary(image: np.ndarray, boundary: Boundary, pixel_aspect: float, white: int) -> None:
    """Draw the circle into a picture or a luma plane: white, and black on either side of it.

    ``white`` is the level of white. The circle is where white is, to a fraction of a pixel.
    """
    shift = 4
    one = 1 << shift
    center = (round(boundary.center[0] * one), round(boundary.center[1] * one))
    radius = boundary.diameter / 2
    axes = (round(radius / pixel_aspect * one), round(radius * one))
    thickness = max(1, round(image.shape[0] / 720))
    for level, width in ((0, 3 * thickness), (white, thickness)):
        colour = (level,) * (image.shape[2] if image.ndim == 3 else 1)
        cv2.ellipse(image, center, axes, 0, 0, 360, colour, width, cv2.LINE_8, shift)
