"""Calibrate from picture files: the job behind ``endocal calibrate``."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

from ..calibration.outcome import Workings
from ..calibration.recorded import options_of
from ..calibration.result import Calibration, Source, SourceImage
from ..calibration.spec import CalibrationSpec
from ..errors import CalibrationError, InputError, UsageError
from ..files.images import Picture
from ..files.picture_header import read_header
from .read_pictures import ReadPicture, check_one_size, copies_among
from .stated_aspect import aspect_notes, calibrate_straightest

_STRANGER = "it does not fit the lens of the other pictures"
_SILENT = "no pattern of straight lines found in it"


class LeftOut(NamedTuple):
    """The path of a picture that a calibration does not rest on, and why."""

    path: str
    reason: str


@dataclass(frozen=True)
class CalibrationReport:
    """The calibration, and the pictures that were left out.

    ``pictures`` are those that it was sought in, by name, and ``workings`` what the calibration rests on.
    ``spec`` is how it was made, with what the pictures' files say. ``notes`` are in words, about pictures.
    """

    calibration: Calibration
    pictures: tuple[tuple[str, Picture], ...]
    workings: Workings
    spec: CalibrationSpec
    left_out: tuple[LeftOut, ...] = ()
    notes: tuple[str, ...] = ()


def calibrate_files(
    paths: Sequence[str | Path], spec: CalibrationSpec = CalibrationSpec()
) -> Calibration:
    """Calibrate as ``report_files`` does, and return the calibration alone."""
    return report_files(paths, spec).calibration


def report_files(
    paths: Sequence[str | Path], spec: CalibrationSpec = CalibrationSpec()
) -> CalibrationReport:
    """Calibrate from one picture file, or jointly from several of one lens at one zoom setting.

    The calibration names its pictures and their SHA-256; its verdict may be "failed". Raises InputError,
    naming the file, for one that cannot be used or is there twice, and CalibrationError where no line is
    found. One that shows what another does is left out. Where ``spec`` gives no pixel aspect, that is taken
    which makes the lines straightest of those that the files may mean, and of square pixels.
    """
    if spec.lines is not None and len(paths) > 1:
        raise UsageError("--lines are those of one picture: give one")
    read = [ReadPicture.of(path) for path in paths]
    check_one_size(read)
    copies = {copy.path: first for copy, first in copies_among(read)}
    kept = [picture for picture in read if picture.path not in copies]
    try:
        made, joint = calibrate_straightest(kept, spec)
    except (InputError, CalibrationError) as error:
        raise type(error)(f"{', '.join(picture.name for picture in kept)}: {error}") from None
    calibration = joint.calibration
    used = tuple(
        SourceImage(Path(picture.path).name, picture.digest, rms if len(kept) > 1 else None)
        for number, (picture, rms) in enumerate(zip(kept, joint.rms, strict=True))
        if number not in (*joint.left_out, *joint.silent)
    )
    options = options_of(made, calibration)
    source = replace(calibration.source or Source(), images=used, options=options)
    reasons = {path: f"it shows the same as {first.name}" for path, first in copies.items()}
    reasons |= {kept[n].path: _STRANGER for n in joint.left_out}
    reasons |= {kept[n].path: _SILENT for n in joint.silent}
    asked = aspect_notes(kept, spec, calibration.model)
    return CalibrationReport(
        replace(calibration, source=source),
        tuple((Path(picture.path).name, picture.image) for picture in kept),
        joint.workings,
        made,
        tuple(LeftOut(str(path), reasons[path]) for path in paths if path in reasons),
        (*_notes(read), *asked),
    )


def _notes(pictures: Sequence[ReadPicture]) -> Iterator[str]:
    for picture in pictures:
        pages = read_header(picture.data).pages
        if pages > 1:
            yield f"{picture.name} holds {pages} pages: only the first is looked at"
