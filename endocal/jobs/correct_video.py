"""Correct a video: reading, remapping and writing at once, in constant memory."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import BinaryIO

from ..errors import InputError, OutputError
from ..files import atomic_output
from ..files.names import shown
from ..remap.engine import FrameRemapper
from ..remap.geometry import OutputGeometry, output_geometry
from ..remap.layout import frame_layout
from ..video.frames import plane_views
from ..video.pipeline import run
from ..video.reader import Item, VideoReader, is_frame
from ..video.stream import StreamInfo
from ..video.writer import OutputPicture, VideoWriter
from .correct import PIPE, CorrectionReport, CorrectionSpec, Progress
from .lens import Lens, ModelSource, model_source, rescaled_note
from .pipe import PipeInput


def correct_video(
    spec: CorrectionSpec,
    lens: Lens,
    source: str | PipeInput,
    progress: Callable[[Progress], None] | None = None,
) -> CorrectionReport:
    """Correct a video; see ``correct``."""
    began = time.monotonic()
    name = shown(spec.input)
    with VideoReader(source, name=name, allow_protocols=spec.allow_protocols) as reader:
        info = reader.info
        notes = [n for n in (rescaled_note(lens, info.size, shown(spec.calibration)),) if n]
        models = model_source(lens, info.size)
        layout = frame_layout(
            info.pix_fmt,
            info.size,
            full_range=info.full_range,
            chroma_location=info.colour.chroma_location or "unspecified",
        )
        geometry = _geometry(spec, info, models)
        remapper = FrameRemapper(layout, geometry, spec.interpolation, spec.device)
        picture = OutputPicture(geometry.size, info.pix_fmt, _out_aspect(geometry))
        with (
            _target(spec) as target,
            VideoWriter(
                target,
                reader,
                picture,
                spec.encoder,
                name=shown(spec.output),
                container_format=spec.container_format,
                strip_metadata=spec.strip_metadata,
            ) as writer,
        ):

            def change(item: Item) -> Item:
                if not is_frame(item):
                    return item
                planes = plane_views(item)
                frame = writer.frame(item)
                model = models.model(planes[0], item.time)
                remapper.apply(model, planes, plane_views(frame))
                return frame

            def tick() -> None:
                if progress is not None:
                    seconds = time.monotonic() - began
                    progress(Progress(writer.frames, _expected(info), seconds))

            run(reader.items(), change, writer.write, is_large=is_frame, tick=tick)
            warnings = _warnings(reader, writer)
            if spec.strict and warnings:
                raise InputError(f"{name}: {'; '.join(warnings)} (--strict)")
        return CorrectionReport(
            input=name,
            output=shown(spec.output),
            frames=writer.frames,
            seconds=time.monotonic() - began,
            size_in=info.size,
            size_out=geometry.size,
            device=remapper.device_name,
            codec=writer.codec,
            duration=info.duration,
            damaged=reader.damaged,
            corrupt=reader.corrupt,
            zoom=dict(models.sources),
            notes=(*notes, *writer.notes),
            warnings=tuple(warnings),
        )


def _geometry(spec: CorrectionSpec, info: StreamInfo, models: ModelSource) -> OutputGeometry:
    return output_geometry(
        models.models,
        models.boundaries,
        view=spec.view,
        size=spec.size,
        scale=spec.scale,
        square_pixels=not spec.keep_sar,
    )


def _out_aspect(geometry: OutputGeometry) -> Fraction:
    return Fraction(geometry.pixel_aspect).limit_denominator(1000)


@contextlib.contextmanager
def _target(spec: CorrectionSpec) -> Iterator[str | BinaryIO]:
    """Give the writer its place: a temporary file that takes the final name at the end, or the pipe."""
    if spec.output == PIPE:
        yield sys.stdout.buffer
        return
    inputs = [p for p in (spec.input, spec.calibration) if p != PIPE]
    with atomic_output(spec.output, overwrite=spec.overwrite, inputs=inputs) as path:
        yield str(path)


def _expected(info: StreamInfo) -> int | None:
    if info.frames is not None:
        return info.frames
    return round(info.duration * info.rate) if info.duration else None


def _warnings(reader: VideoReader, writer: VideoWriter) -> list[str]:
    """Say what was wrong with the input, once it has been read to its end."""
    warnings = []
    declared = reader.info.frames
    if writer.frames == 0:
        raise OutputError(f"{reader.name}: no frame could be decoded, so there is nothing to write")
    if reader.damaged:
        warnings.append(f"{reader.damaged} damaged packets could not be decoded")
    if reader.corrupt:
        warnings.append(f"{reader.corrupt} frames were decoded with errors")
    if reader.truncated:
        warnings.append("the file breaks off before its end")
    elif declared is not None and writer.frames < declared:
        warnings.append(f"only {writer.frames} of the {declared} frames that it declares are there")
    return warnings
