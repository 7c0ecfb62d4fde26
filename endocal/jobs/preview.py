"""One instant before and after correction: the job behind ``endocal correct --preview``."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import partial

import cv2
import numpy as np

from ..errors import InputError, UsageError
from ..files import decode_image, load, read_picture_bytes, upright
from ..files.names import shown
from ..model import DivisionModel
from ..remap.engine import FrameRemapper
from ..remap.geometry import OutputGeometry
from ..remap.layout import frame_layout, supported
from ..video.frames import Frame, to_bgr
from ..video.reader import Item, VideoReader, is_frame
from .before_after import Picture, before_after
from .correct import holds_picture
from .correct_picture import check_picture_output, write_picture
from .correct_video import eye_sources, fit_eyes
from .correction import CorrectionSpec, input_name, output_name
from .corrector import Split, stream_geometry
from .instant import Instant
from .lens import Lens, ModelSource, fit_lens, model_source
from .pipe import NOTHING_CAME, PIPE, PipeInput
from .whole_frames import WholeFrames

# Before an instant that is given as a time the zoom is followed for so long: what it was before that hardly
# counts any more.
LEAD_S = 10.0
# A frame's time may be off by the rounding of its time base.
_SAME_TIME_S = 1e-3


@dataclass(frozen=True)
class PreviewReport:
    """What was shown.

    ``frame`` is the number of the frame (None where it was found by its time) and ``time`` its own, s from
    the start; ``lam`` px^-2 and ``center`` px are those of the model, the left or upper eye's of stereo;
    ``size`` is the picture's (width, height) in px.
    """

    input: str
    output: str
    frame: int | None
    time: float | None
    lam: float
    center: tuple[float, float]
    size: tuple[int, int]
    notes: tuple[str, ...] = ()


def preview(spec: CorrectionSpec, instant: Instant) -> PreviewReport:
    """Write a picture of the input at one instant: before | after, with a grid that shows the bending.

    What ``spec`` says of the picture counts as for ``correct``, codecs and containers do not. A frame is
    counted from the start, and its zoom is what ``correct`` follows; a time is sought, and the zoom followed
    from LEAD_S before it. Raises InputError where the video ends before, and what ``correct`` raises.
    """
    for option, given in (
        ("--side-by-side", spec.side_by_side),
        ("--zoom-log", spec.zoom_log),
        ("--live", spec.live),
    ):
        if given:
            raise UsageError(f"--preview excludes {option}")
    check_picture_output(spec)
    lens = load(spec.calibration)
    source = PipeInput() if spec.input == PIPE else spec.input
    if isinstance(source, PipeInput) and not source.peek(1):
        raise InputError(f"stdin: is empty: {NOTHING_CAME}")
    if holds_picture(source):
        return _of_picture(spec, lens, instant, source)
    return _of_video(spec, lens, instant, source)


def _of_picture(
    spec: CorrectionSpec, lens: Lens, instant: Instant, source: str | PipeInput
) -> PreviewReport:
    name = input_name(spec)
    if instant.frame or instant.time:
        raise InputError(f"{name}: is a picture, with no {instant}: --preview 0 shows it")
    data = read_picture_bytes(source) if isinstance(source, str) else source.read()
    image = decode_image(data, name)
    if image.dtype == np.uint16:
        image = (image >> 8).astype(np.uint8)
    lens, note = fit_lens(lens, (image.shape[1], image.shape[0]), None, shown(spec.calibration))
    grey = image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    models = model_source(lens, spec.lookup, spec.center, spec.assume_diameter)
    model = models.model(lambda: np.asarray(grey), None)
    bgr = image if image.ndim == 3 else cv2.cvtColor(image, cv2.COLOR_GRAY2BGR)
    geometry = stream_geometry(spec, frame_layout("bgr24", model.size, full_range=True), [models])
    picture = _picture(spec, np.asarray(bgr), model, geometry, "")
    turned = np.asarray(upright(picture, data), np.uint8)
    return _written(spec, turned, model, None, None, [note, *models.notes])


def _of_video(
    spec: CorrectionSpec, lens: Lens, instant: Instant, source: str | PipeInput
) -> PreviewReport:
    right = None if spec.right_calibration is None else load(spec.right_calibration)
    lenses = [lens] if spec.stereo is None else [lens, right or lens]
    with VideoReader(
        source,
        name=input_name(spec),
        threads=spec.threads,
        accepts=supported,
        allow_protocols=spec.allow_protocols,
    ) as reader:
        whole = WholeFrames(reader, spec.deinterlace, spec.threads)
        info = whole.info
        split = Split(info, spec.stereo)
        fitted, notes = fit_eyes(spec, lenses, split, info)
        eyes = eye_sources(spec, fitted, split, None, reader)
        start = info.start or 0.0
        # A record may count the frames from the first on.
        if instant.time is not None and spec.zoom_from is None:
            reader.go_to(start + instant.time - LEAD_S)
        found = _found(whole.items(), instant, start, split, eyes)
        if found is None:
            raise InputError(f"{input_name(spec)}: ends before {instant}")
        frame, models = found
        geometry = stream_geometry(spec, split.layout, eyes)
        time = None if frame.time is None else frame.time - start
        number = "" if instant.frame is None else f"frame {instant.frame}, "
        words = f"{number}{time:.2f} s" if time is not None else number.rstrip(", ")
        bgr = to_bgr(frame)
        views = [
            _picture(spec, split.cut(bgr, eye), model, geometry, words)
            for eye, model in enumerate(models)
        ]
        said = [*notes, *(note for eye in eyes for note in eye.notes)]
        return _written(spec, np.vstack(views), models[0], instant.frame, time, said)


def _found(
    items: Iterable[Item], instant: Instant, start: float, split: Split, eyes: Sequence[ModelSource]
) -> tuple[Frame, list[DivisionModel]] | None:
    """Return the frame of an instant with each eye's model; None where the video ends before it."""
    found: tuple[Frame, list[DivisionModel]] | None = None
    end = -math.inf
    for number, frame in enumerate(filter(is_frame, items)):
        if instant.time is not None:
            time = number if frame.time is None else frame.time - start
            if found is not None and time > instant.time + _SAME_TIME_S:
                return found
            end = time + (float(frame.duration * frame.time_base) if frame.duration else 0.1)
        models = [
            source.model(partial(split.luma, frame, eye), frame.time)
            for eye, source in enumerate(eyes)
        ]
        found = frame, models
        if number == instant.frame:
            return found
    # The last frame is shown until the end.
    return found if instant.time is not None and instant.time <= end + _SAME_TIME_S else None


def _picture(
    spec: CorrectionSpec,
    bgr: Picture,
    model: DivisionModel,
    geometry: OutputGeometry,
    words: str,
) -> Picture:
    layout = frame_layout("bgr24", model.size, full_range=True)
    remapper = FrameRemapper(layout, geometry, spec.interpolation, spec.device)
    w, h = geometry.size
    after = np.zeros((h, w, 3), np.uint8)
    flat = np.ascontiguousarray(bgr).reshape(bgr.shape[0], -1)
    remapper.apply(model, [flat], [after.reshape(h, -1)])
    return before_after(bgr, after, model, geometry, words)


def _written(
    spec: CorrectionSpec,
    picture: Picture,
    model: DivisionModel,
    frame: int | None,
    time: float | None,
    notes: Iterable[str | None],
) -> PreviewReport:
    write_picture(spec, picture)
    return PreviewReport(
        input=input_name(spec),
        output=output_name(spec),
        frame=frame,
        time=time,
        lam=model.lam,
        center=model.center,
        size=(picture.shape[1], picture.shape[0]),
        notes=tuple(note for note in notes if note),
    )
