"""The pixel aspect of pictures that nobody gives: what their files say, if the lines bear it out.

What files say means one thing or its reverse (see ``stated_pixel_shape``), or is wrong. But a lens bends
lines alike across and down, and under a wrong pixel aspect no model of it makes them as straight.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

from ..calibration.calibrate import Joint, calibrate_jointly
from ..calibration.spec import CalibrationSpec
from ..errors import CalibrationError
from ..files.pixel_shape import stated_pixel_shape
from ..model import DivisionModel
from .read_pictures import ReadPicture

# The best first. Lines that stay bent make a calibration doubtful, however little noise there is beside.
VERDICTS = ("good", "doubtful", "failed")
# Of pixel aspects that make lines straight alike, within this, the likeliest is taken.
AS_STRAIGHT = 1.01
# Frame sizes of video whose pixels are seldom square, and how wide they are at 4:3 and at 16:9.
VIDEO = {
    (720, 576): (16 / 15, 64 / 45),
    (704, 576): (12 / 11, 16 / 11),
    (720, 480): (8 / 9, 32 / 27),
    (704, 480): (10 / 11, 40 / 33),
    (1440, 1080): (4 / 3,),
}


def _pixel_aspects(pictures: Sequence[ReadPicture]) -> list[float]:
    """The pixel aspects that the files may mean, the likeliest first, and 1."""
    stated = dict.fromkeys(filter(None, (stated_pixel_shape(picture.data) for picture in pictures)))
    return [*(float(a) for ratio in stated for a in (ratio, 1 / ratio)), 1.0]


def calibrate_straightest(
    pictures: Sequence[ReadPicture], spec: CalibrationSpec
) -> tuple[CalibrationSpec, Joint]:
    """Calibrate from pictures, and return how, too: with which pixel aspect.

    That is the ``spec``'s, or that one which fits best. Bare methods do not tell how straight lines are:
    their pixels are square, if nobody says otherwise. Raises what ``calibrate_jointly`` does.
    """
    aspects = _pixel_aspects(pictures)
    images = [picture.image for picture in pictures]
    if spec.pixel_aspect is not None or not spec.refine or len(aspects) == 1:
        return spec, calibrate_jointly(images, spec)
    found: list[tuple[int, float, CalibrationSpec, Joint]] = []
    refused: CalibrationError | None = None
    for aspect in aspects:
        tried = replace(spec, pixel_aspect=aspect)
        try:
            joint = calibrate_jointly(images, tried)
        except CalibrationError as error:
            refused = error
            continue
        quality = joint.calibration.quality
        if quality is not None and quality.rms is not None:
            # Where pixels count as wide, so do distances across.
            off = quality.rms / math.sqrt(aspect)
            found.append((VERDICTS.index(quality.verdict), off, tried, joint))
    if not found:
        raise refused or CalibrationError("no straight lines found")
    best, least, _, _ = min(found, key=lambda one: one[:2])
    return next(
        (tried, joint)
        for verdict, off, tried, joint in found
        if verdict == best and off <= AS_STRAIGHT * least
    )


def aspect_notes(
    pictures: Sequence[ReadPicture], spec: CalibrationSpec, made: DivisionModel
) -> Iterator[str]:
    """Yield what was ``made`` of what files state, where ``spec`` gives no pixel aspect; or ask for it."""
    if spec.pixel_aspect is not None:
        return
    states = [stated_pixel_shape(picture.data) for picture in pictures]
    if made.size in VIDEO and not any(states):
        usual = " or ".join(f"{aspect:.4f}" for aspect in VIDEO[made.size])
        yield (
            f"video of {made.size[0]}x{made.size[1]} mostly has pixels that are not square, but {usual} times"
            " as wide as high, and its stills seldom say so: give --pixel-aspect, 1 where they are square"
        )
    for picture, stated in zip(pictures, states, strict=True):
        if stated is None:
            continue
        numbers = f"{picture.name} says {stated.numerator}:{stated.denominator} of its pixels"
        if not spec.refine:
            yield f"{numbers}, which a bare method does not try: give --pixel-aspect"
        elif made.pixel_aspect == 1:
            yield f"{numbers}, which its lines do not bear out: taken as square, but for --pixel-aspect"
        else:
            yield f"{numbers}: taken as {made.pixel_aspect:.4f} times as wide as high, as its lines bear out"
