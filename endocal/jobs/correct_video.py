"""Correct a video: reading, remapping and writing at once, in constant memory."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from functools import partial

import numpy as np

from ..errors import InputError
from ..files import atomic_output
from ..files.names import shown
from ..remap.engine import FrameRemapper
from ..remap.geometry import OutputGeometry, output_geometry
from ..remap.layout import FrameLayout, frame_layout, supported
from ..video.frames import Frame, luma_view, plane_views
from ..video.pipeline import run
from ..video.reader import Item, VideoReader, is_frame
from ..video.stream import StreamInfo
from ..video.writer import OutputPicture, VideoWriter
from .correct import CorrectionReport, CorrectionSpec, Progress, input_name, output_name
from .lens import Lens, ModelSource, fit_lens, model_source
from .live_feed import LiveFeed
from .pipe import PIPE, PipeInput, PipeOutput
from .side_by_side import SideBySide
from .whole_frames import WholeFrames
from .zoom_log import RecordedZoom, ZoomLog, zoom_log


def correct_video(
    spec: CorrectionSpec,
    lens: Lens,
    source: str | PipeInput,
    progress: Callable[[Progress], None] | None = None,
) -> CorrectionReport:
    """Correct a video; see ``correct``."""
    began = time.monotonic()
    name = input_name(spec)
    with VideoReader(
        source,
        name=name,
        accepts=supported,
        allow_protocols=spec.allow_protocols,
        live=spec.live,
    ) as reader:
        feed = LiveFeed() if spec.live else None
        whole = WholeFrames(reader, spec.deinterlace)
        info = whole.info
        aspect = None if info.sample_aspect is None else float(info.sample_aspect)
        lens, note = fit_lens(lens, info.size, aspect, shown(spec.calibration))
        with _zoom_log(spec) as log, _target(spec) as target:
            models = _models(spec, lens, log, reader)
            corrector = _Corrector(spec, info, models)
            with VideoWriter(
                target,
                reader,
                info,
                corrector.picture,
                replace(spec.encoder, live=spec.live),
                name=output_name(spec),
                container_format=_container(spec, info),
                strip_metadata=spec.strip_metadata,
            ) as writer:

                def change(item: Item) -> Item:
                    if not is_frame(item):
                        return item
                    frame = writer.frame(item)
                    corrector.apply(item, frame)
                    return frame

                def tick() -> None:
                    if progress is not None:
                        seconds = time.monotonic() - began
                        progress(Progress(writer.frames, _expected(info), seconds))

                def write(item: Item) -> None:
                    # The writer uses the frame again as soon as it has it.
                    pts = item.pts
                    writer.write(item)
                    if feed is not None and is_frame(item) and pts is not None:
                        feed.left(pts)

                items = whole.items()
                run(
                    items if feed is None else feed.items(items),
                    change,
                    write,
                    is_large=is_frame,
                    tick=tick,
                    on_stop=source.stop if isinstance(source, PipeInput) else lambda: None,
                    on_interrupt=None if feed is None else feed.stop,
                    drop=None if feed is None else feed.drop,
                )
                warnings = _warnings(reader, writer)
                if spec.strict and warnings:
                    raise InputError(f"{name}: {'; '.join(warnings)} (--strict)")
        return CorrectionReport(
            input=name,
            output=output_name(spec),
            frames=writer.frames,
            seconds=time.monotonic() - began,
            size_in=info.size,
            size_out=corrector.picture.size,
            device=corrector.device,
            codec=writer.codec,
            duration=info.duration,
            damaged=reader.damaged,
            corrupt=reader.corrupt,
            zoom=dict(models.sources),
            latency=None if feed is None else feed.latency(),
            notes=(*([note] if note else ()), *models.notes, *whole.notes(), *writer.notes),
            warnings=tuple(warnings),
        )


class _Corrector:
    """Turns the planes of a frame into those of the output; ``picture`` says what comes out."""

    def __init__(self, spec: CorrectionSpec, info: StreamInfo, models: ModelSource) -> None:
        self._models = models
        layout = frame_layout(
            info.pix_fmt,
            info.size,
            full_range=info.full_range,
            chroma_location=info.colour.chroma_location or "unspecified",
        )
        geometry = _geometry(spec, layout, models)
        self._remapper = FrameRemapper(layout, geometry, spec.interpolation, spec.device)
        self._beside: SideBySide | None = None
        size = geometry.size
        if spec.side_by_side:
            self._beside = SideBySide(layout, self._remapper.output_layout)
            size = self._beside.size
        aspect = info.sample_aspect
        if geometry.pixel_aspect != (1.0 if aspect is None else float(aspect)):
            aspect = Fraction(geometry.pixel_aspect).limit_denominator(1000)
        self.picture = OutputPicture(size, info.pix_fmt, aspect)

    @property
    def device(self) -> str:
        """The name of the device that remaps."""
        return self._remapper.device_name

    def apply(self, frame: Frame, target: Frame) -> None:
        """Fill the frame ``target`` from the next frame of the input."""
        planes, out = plane_views(frame), plane_views(target)
        model = self._models.model(partial(luma_view, frame), frame.time)
        if self._beside is None:
            self._remapper.apply(model, planes, out)
            return
        self._beside.fill_gaps(out)
        for plane, view in zip(planes, self._beside.left(out), strict=True):
            view[...] = plane
        self._remapper.apply(model, planes, self._beside.right(out))


def _models(
    spec: CorrectionSpec, lens: Lens, log: ZoomLog | None, reader: VideoReader
) -> ModelSource:
    recorded = None if spec.zoom_from is None else RecordedZoom(spec.zoom_from)

    def ahead() -> Iterator[np.ndarray]:
        return map(luma_view, reader.from_start() or ())

    return model_source(lens, spec.lookup, spec.assume_diameter, recorded, log, ahead)


def _geometry(spec: CorrectionSpec, layout: FrameLayout, models: ModelSource) -> OutputGeometry:
    """Lay out the output; a size that nobody asked for is made to fit whole chroma samples."""
    # Beside the original, which keeps its pixels, the corrected frame has to keep them too.
    square = not (spec.keep_sar or spec.side_by_side)

    def lay_out(size: tuple[int, int] | None, scale: float | None) -> OutputGeometry:
        return output_geometry(
            models.models, models.boundaries, spec.view, size, scale, square_pixels=square
        )

    geometry = lay_out(spec.size, spec.scale)
    steps = [plane.step for plane in layout.planes]
    whole = tuple(n + n % max(step[axis] for step in steps) for axis, n in enumerate(geometry.size))
    if spec.size is not None or geometry.size in (whole, layout.size):
        return geometry
    return lay_out((whole[0], whole[1]), None)


def _container(spec: CorrectionSpec, info: StreamInfo) -> str | None:
    """Name the output's container where its suffix does not: on a pipe, that of the input if it can flow."""
    if spec.container_format is not None or spec.output != PIPE:
        return spec.container_format
    return info.container if info.container in ("yuv4mpegpipe", "mpegts") else "matroska"


@contextlib.contextmanager
def _target(spec: CorrectionSpec) -> Iterator[str | PipeOutput]:
    """Give the writer its place: a temporary file that takes the final name at the end, or the pipe."""
    if spec.output == PIPE:
        yield PipeOutput()
        return
    with atomic_output(spec.output, overwrite=spec.overwrite, inputs=_inputs(spec)) as path:
        yield str(path)


@contextlib.contextmanager
def _zoom_log(spec: CorrectionSpec) -> Iterator[ZoomLog | None]:
    if spec.zoom_log is None:
        yield None
        return
    with zoom_log(spec.zoom_log, spec.overwrite, _inputs(spec)) as log:
        yield log


def _inputs(spec: CorrectionSpec) -> list[str]:
    paths = (spec.input, spec.calibration, spec.zoom_from)
    return [path for path in paths if path not in (None, PIPE)]


def _expected(info: StreamInfo) -> int | None:
    if info.frames is not None:
        return info.frames
    return round(info.duration * info.rate) if info.duration else None


def _warnings(reader: VideoReader, writer: VideoWriter) -> list[str]:
    """Say what was wrong with the input, once it has been read to its end."""
    warnings = []
    declared = reader.info.frames
    if reader.damaged:
        warnings.append(f"{reader.damaged} damaged packets could not be decoded")
    if reader.corrupt:
        warnings.append(f"{reader.corrupt} frames were decoded with errors")
    if writer.dropped:
        warnings.append(f"{writer.dropped} damaged packets of other streams could not be copied")
    if reader.truncated:
        warnings.append("the file breaks off before its end")
    elif declared is not None and reader.decoded + reader.hidden < declared:
        warnings.append(
            f"only {reader.decoded} of the {declared} frames that it declares are there"
        )
    return warnings
