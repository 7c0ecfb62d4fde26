"""Calibrate from picture files: the job behind ``endocal calibrate``."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

from ..calibration.image.picture import to_grey
from ..calibration.outcome import Workings
from ..calibration.recorded import options_of
from ..calibration.result import Calibration, Source, SourceImage
from ..calibration.spec import CalibrationSpec
from ..errors import CalibrationError, InputError, UsageError
from ..files import decode_image, read_picture_bytes
from ..files.images import Picture
from ..files.names import shown
from ..files.picture_header import read_header
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

    ``pictures`` are those that were given, by name, and ``workings`` what the calibration rests on. ``spec``
    is how it was made, with what the pictures' files say. ``notes`` are in words, about pictures.
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
    found. Where ``spec`` gives no pixel aspect, that is taken which makes the lines straightest of those that
    the files may mean, and of square pixels.
    """
    if spec.lines is not None and len(paths) > 1:
        raise UsageError("--lines are those of one picture: give one")
    given = spec.pixel_aspect
    contents = [read_picture_bytes(path) for path in paths]
    digests = [hashlib.sha256(data).hexdigest() for data in contents]
    images = [decode_image(data, str(path)) for data, path in zip(contents, paths, strict=True)]
    _check_distinct(paths, images)
    for path, image in zip(paths[1:], images[1:], strict=True):
        if image.shape[:2] != images[0].shape[:2]:
            raise InputError(
                f"{shown(path)} is {image.shape[1]}x{image.shape[0]}, {shown(paths[0])}"
                f" {images[0].shape[1]}x{images[0].shape[0]}: give pictures of one lens at one setting"
            )
    try:
        spec, joint = calibrate_straightest(images, contents, spec)
    except (InputError, CalibrationError) as error:
        raise type(error)(f"{', '.join(shown(path) for path in paths)}: {error}") from None
    calibration = joint.calibration
    pictures = tuple(
        SourceImage(Path(path).name, digest, rms if len(paths) > 1 else None)
        for number, (path, digest, rms) in enumerate(zip(paths, digests, joint.rms, strict=True))
        if number not in (*joint.left_out, *joint.silent)
    )
    options = options_of(spec, calibration)
    source = replace(calibration.source or Source(), images=pictures, options=options)
    reasons = dict.fromkeys(joint.left_out, _STRANGER) | dict.fromkeys(joint.silent, _SILENT)
    left_out = tuple(LeftOut(str(paths[n]), reasons[n]) for n in sorted(reasons))
    return CalibrationReport(
        replace(calibration, source=source),
        tuple((Path(path).name, image) for path, image in zip(paths, images, strict=True)),
        joint.workings,
        spec,
        left_out,
        (
            *_notes(paths, contents),
            *aspect_notes(paths, contents, given, calibration.model, spec.refine),
        ),
    )


def _notes(paths: Sequence[str | Path], contents: Sequence[bytes]) -> Iterator[str]:
    for path, data in zip(paths, contents, strict=True):
        pages = read_header(data).pages
        if pages > 1:
            yield f"{shown(path)} holds {pages} pages: only the first is looked at"


def _check_distinct(paths: Sequence[str | Path], images: Sequence[Picture]) -> None:
    """Refuse a picture that is there twice: counted as evidence of its own, it would make all look surer.

    What counts is what is seen: the same pixels in a file of another kind are the same picture.
    """
    if len(images) < 2:
        return
    seen: dict[tuple[tuple[int, ...], str], str | Path] = {}
    for path, image in zip(paths, images, strict=True):
        grey = to_grey(image)
        pixels = grey.shape, hashlib.sha256(grey.data).hexdigest()
        if pixels in seen:
            raise InputError(
                f"{shown(path)}: the same picture as {shown(seen[pixels])}: give it once"
            )
        seen[pixels] = path
