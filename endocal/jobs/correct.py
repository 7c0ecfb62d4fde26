"""Correct a video or a picture: the job behind ``endocal correct``."""

from __future__ import annotations

from collections.abc import Callable

from ..errors import InputError, UsageError
from ..files import load
from ..files.moving import is_moving
from ..files.picture_header import SIGNATURE_BYTES, known_kind
from ..zoom.table import ZoomTable
from .correct_video import correct_video
from .correction import CorrectionReport, CorrectionSpec, Progress, input_name
from .pipe import NOTHING_CAME, PipeInput, open_input

# Bare motion JPEG begins like a picture, and may hold but one.
_MOTION_JPEG = (".mjpeg", ".mjpg")


def correct(
    spec: CorrectionSpec, progress: Callable[[Progress], None] | None = None
) -> CorrectionReport:
    """Correct the input with its calibration or zoom table and write the output, complete or not at all.

    ``progress`` is called in this thread, about ten times a second. Raises EndocalError with what, where and
    what to do; with ``strict``, for damage too that is otherwise only a warning.
    """
    lens = load(spec.calibration)
    right = None if spec.right_calibration is None else load(spec.right_calibration)
    if not isinstance(lens, ZoomTable):
        _refuse_zoom_options(spec)
    source = open_input(spec.input)
    if isinstance(source, PipeInput) and not source.peek(1):
        raise InputError(f"{input_name(spec)}: is empty: {NOTHING_CAME}")
    if holds_picture(source):
        # OpenCV, which pictures are read and written with, takes a while to import.
        from .correct_picture import correct_picture

        return correct_picture(spec, lens, source)
    lenses = [lens] if spec.stereo is None else [lens, right or lens]
    return correct_video(spec, lenses, source, progress)


def _refuse_zoom_options(spec: CorrectionSpec) -> None:
    for option, given in (
        ("--zoom-log", spec.zoom_log is not None),
        ("--zoom-from", spec.zoom_from is not None),
        ("--assume-diameter", spec.assume_diameter is not None),
        ("--lookup", spec.lookup != "auto"),
    ):
        if given:
            raise UsageError(
                f"{option} needs a zoom table, and {spec.calibration} is a calibration"
            )


def holds_picture(source: str | PipeInput) -> bool:
    """Tell a still picture from a video by how it begins; a missing file is left for others to report."""
    if isinstance(source, PipeInput):
        return known_kind(source.peek(SIGNATURE_BYTES)) and not is_moving(source.peek)
    if source.lower().endswith(_MOTION_JPEG):
        return False

    def peek(size: int) -> bytes:
        file.seek(0)
        return file.read(size)

    try:
        with open(source, "rb") as file:
            return known_kind(peek(SIGNATURE_BYTES)) and not is_moving(peek)
    except (OSError, ValueError):
        return False
