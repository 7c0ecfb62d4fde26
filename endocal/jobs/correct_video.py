"""Correct a video: reading, remapping and writing at once, in constant memory."""

from __future__ import annotations

import contextlib
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from ..errors import InputError, OutputError
from ..files import atomic_output
from ..files.names import shown
from ..remap.engine import Pending, load_device, prepare_device
from ..remap.layout import supported
from ..video.pipeline import run
from ..video.reader import Item, VideoReader, is_frame
from ..video.stream import StreamInfo
from ..video.writer import VideoWriter
from .background import Background
from .correction import CorrectionReport, CorrectionSpec, Progress, input_name, output_name
from .corrector import Corrector, Split
from .lens import Lens, ModelSource, fit_lens, model_source
from .live_feed import LiveFeed
from .pipe import PIPE, PipeInput, PipeOutput
from .whole_frames import WholeFrames
from .zoom_log import RecordedZoom, ZoomLog, zoom_log


def correct_video(
    spec: CorrectionSpec,
    lenses: Sequence[Lens],
    source: str | PipeInput,
    progress: Callable[[Progress], None] | None = None,
) -> CorrectionReport:
    """Correct a video; see ``correct``. ``lenses`` holds one for each eye."""
    began = time.monotonic()
    name = input_name(spec)
    # While the input is opened and its first frames are decoded.
    prepare_device(spec.device)
    device = Background(partial(load_device, spec.device))
    with VideoReader(
        source,
        name=name,
        threads=spec.threads,
        accepts=supported,
        allow_protocols=spec.allow_protocols,
        live=spec.live,
    ) as reader:
        feed = LiveFeed() if spec.live else None
        whole = WholeFrames(reader, spec.deinterlace, spec.threads)
        info = whole.info
        split = Split(info, spec.stereo)
        fitted, notes = fit_eyes(spec, lenses, split, info)
        with _zoom_log(spec) as log, _target(spec) as target:
            eyes = eye_sources(spec, fitted, split, log, reader)
            device.result()
            corrector = Corrector(spec, info, split, eyes)
            with VideoWriter(
                target,
                reader,
                info,
                corrector.picture,
                replace(spec.encoder, live=spec.live, threads=spec.threads),
                name=output_name(spec),
                container_format=_container(spec, info),
                strip_metadata=spec.strip_metadata,
            ) as writer:
                under_way: deque[list[Pending]] = deque()

                def change(item: Item) -> Item:
                    if not is_frame(item):
                        return item
                    frame = writer.frame(item)
                    under_way.append(corrector.start(item, frame))
                    return frame

                def tick() -> None:
                    if progress is not None:
                        seconds = time.monotonic() - began
                        progress(Progress(writer.frames, _expected(info), seconds))

                def write(item: Item) -> None:
                    if is_frame(item):
                        for pending in under_way.popleft():
                            pending.wait()
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
                due = whole.frames_for(reader.decoded)
                if feed is None and writer.frames != due:
                    raise OutputError(
                        f"{output_name(spec)}: {writer.frames} frames came out where {due} are due"
                    )
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
            zoom=dict(sum((eye.sources for eye in eyes), Counter())),
            diameters=_range([eye.diameters for eye in eyes if eye.diameters is not None]),
            latency=None if feed is None else feed.latency(),
            notes=(
                *notes,
                *dict.fromkeys(note for eye in eyes for note in eye.notes),
                *whole.notes(),
                *(f"{what} cannot be kept, and is left out" for what in info.extras),
                *writer.notes,
            ),
            warnings=tuple(warnings),
        )


def eye_sources(
    spec: CorrectionSpec,
    lenses: Sequence[Lens],
    split: Split,
    log: ZoomLog | None,
    reader: VideoReader,
) -> list[ModelSource]:
    """Return where each eye's models come from."""
    recorded = None if spec.zoom_from is None else RecordedZoom(spec.zoom_from)

    def look_ahead(eye: int) -> Iterator[tuple[np.ndarray, float | None]]:
        return ((split.luma(frame, eye), frame.time) for frame in reader.from_start() or ())

    return [
        model_source(
            lens,
            spec.lookup,
            spec.center,
            spec.assume_diameter,
            recorded,
            log,
            partial(look_ahead, eye),
        )
        for eye, lens in enumerate(lenses)
    ]


def fit_eyes(
    spec: CorrectionSpec, lenses: Sequence[Lens], split: Split, info: StreamInfo
) -> tuple[list[Lens], list[str]]:
    """Fit each eye's lens to its part of the frame; return the lenses and what is to be said of them."""
    aspect = None if info.sample_aspect is None else float(info.sample_aspect)
    names = [spec.calibration, spec.right_calibration or spec.calibration]
    fitted, notes = [], []
    for lens, name in zip(lenses, names, strict=False):
        one, note = fit_lens(lens, split.layout.size, aspect, shown(name))
        fitted.append(one)
        notes += [note] if note and note not in notes else []
    return fitted, notes


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
    paths = (spec.input, spec.calibration, spec.right_calibration, spec.zoom_from)
    return [path for path in paths if path not in (None, PIPE)]


def _range(ranges: Sequence[tuple[float, float]]) -> tuple[float, float] | None:
    """Return the range that spans all of them."""
    if not ranges:
        return None
    return min(r[0] for r in ranges), max(r[1] for r in ranges)


def _expected(info: StreamInfo) -> int | None:
    if info.frames is not None:
        return info.frames
    return round(info.duration * info.rate) if info.duration else None


def _warnings(reader: VideoReader, writer: VideoWriter) -> list[str]:
    """Say what was wrong with the input, once it has been read to its end."""
    warnings = list(reader.faults())
    if writer.dropped:
        plural = "" if writer.dropped == 1 else "s"
        warnings.append(
            f"{writer.dropped} damaged packet{plural} of other streams could not be copied"
        )
    return warnings
