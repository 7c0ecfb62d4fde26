"""Correct a still picture: the same command as for a video."""

from __future__ import annotations

import time
from functools import partial
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from ..errors import UsageError
from ..files import (
    check_output,
    decode_image,
    encode_image,
    read_picture_bytes,
    upright,
    write_image,
)
from ..files.images import ALPHA_SUFFIXES, PICTURE_SUFFIXES, Picture, without_alpha
from ..files.names import shown
from ..remap.remapper import Remapper
from .correction import CorrectionReport, CorrectionSpec, input_name, output_name
from .lens import Lens, fit_lens, model_source
from .pipe import PIPE, PipeInput, PipeOutput

# A picture on a pipe has no suffix to name its kind.
_PIPE_SUFFIX = ".png"
_OPAQUE = {"uint8": 255, "uint16": 65535}


def correct_picture(spec: CorrectionSpec, lens: Lens, source: str | PipeInput) -> CorrectionReport:
    """Correct a picture; see ``correct``. With a zoom table its visible circle tells the zoom."""
    began = time.monotonic()
    _check(spec)
    name = input_name(spec)
    data = read_picture_bytes(source) if isinstance(source, str) else source.read()
    image, lost = _decode(data, spec, name)
    size = (image.shape[1], image.shape[0])
    lens, note = fit_lens(lens, size, None, shown(spec.calibration))
    models = model_source(lens, spec.lookup, spec.center, spec.assume_diameter)
    model = models.model(partial(_luma, image), None)
    remapper = Remapper(
        model,
        device=spec.device,
        view=spec.view,
        interpolation=spec.interpolation,
        size=spec.size,
        scale=spec.scale,
        boundary=models.boundaries[0] if len(models.boundaries) == 1 else None,
    )
    # The lens is in the sensor's frame; what is written carries no EXIF tag, so it is turned for the eye.
    corrected: Picture = upright(remapper.apply(image), data)
    if spec.side_by_side:
        corrected = _beside(upright(image, data), corrected)
    write_picture(spec, corrected)
    return CorrectionReport(
        input=name,
        output=output_name(spec),
        frames=1,
        seconds=time.monotonic() - began,
        size_in=size,
        size_out=(corrected.shape[1], corrected.shape[0]),
        device=remapper.device_name,
        zoom=dict(models.sources),
        diameters=models.diameters,
        notes=tuple(filter(None, (note, lost))),
    )


def _decode(data: bytes, spec: CorrectionSpec, name: str) -> tuple[Picture, str | None]:
    """Return the picture, with its transparency where the output holds it, and a note where it does not."""
    image = decode_image(data, name, keep_alpha=True)
    suffix = _PIPE_SUFFIX if spec.output == PIPE else Path(spec.output).suffix.lower()
    if image.ndim == 2 or image.shape[2] == 3 or suffix in ALPHA_SUFFIXES:
        return image, None
    return without_alpha(image), f"{suffix} holds no transparency: it is left out; .png keeps it"


def _check(spec: CorrectionSpec) -> None:
    encoder = spec.encoder
    for option, given in (
        ("--codec", encoder.codec),
        ("--crf", encoder.crf),
        ("--preset", encoder.preset),
        ("--pix-fmt", encoder.pix_fmt),
        ("--codec-option", encoder.options),
        ("--format", spec.container_format),
        ("--stereo", spec.stereo),
        ("--zoom-log", spec.zoom_log),
        ("--zoom-from", spec.zoom_from),
    ):
        if given:
            raise UsageError(f"{option} is for videos; {input_name(spec)} is a picture")
    check_picture_output(spec)


def check_picture_output(spec: CorrectionSpec) -> None:
    """Raise what ``write_picture`` would, before the work."""
    if spec.output != PIPE and Path(spec.output).suffix.lower() not in PICTURE_SUFFIXES:
        raise UsageError(
            f"{shown(spec.output)}: a picture is written as {', '.join(PICTURE_SUFFIXES)}"
        )
    inputs = (spec.input, spec.calibration, spec.zoom_from)
    check_output(spec.output, spec.overwrite, [p for p in inputs if p not in (None, PIPE)])


def _luma(image: Picture) -> Picture:
    colour = without_alpha(image)
    grey: Any = colour if colour.ndim == 2 else cv2.cvtColor(colour, cv2.COLOR_BGR2GRAY)
    return grey


def _beside(left: Picture, right: Picture) -> Picture:
    """Put two pictures side by side, the lower one with black below it."""
    height = max(left.shape[0], right.shape[0])
    beside = [
        np.pad(p, ((0, height - p.shape[0]), *((0, 0),) * (p.ndim - 1))) for p in (left, right)
    ]
    for picture, padded in zip((left, right), beside, strict=True):
        if padded.ndim == 3 and padded.shape[2] == 4:
            padded[picture.shape[0] :, :, 3] = _OPAQUE[padded.dtype.name]
    return np.hstack(beside)


def write_picture(spec: CorrectionSpec, image: Picture) -> None:
    """Write a picture where ``spec`` says; on a pipe it is a PNG."""
    if spec.output == PIPE:
        PipeOutput().write(encode_image(image, _PIPE_SUFFIX))
        return
    write_image(spec.output, image, overwrite=spec.overwrite)
