"""The pixel aspect of pictures that nobody gives: what their files say, if the lines bear it out.

What files say means one thing or its reverse (see ``stated_pixel_shape``), or is wrong. But a lens bends
lines alike across and down, and under a wrong pixel aspect no model of it makes them as straight.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction

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


def calibrate_straightest(
    pictures: Sequence[ReadPicture], spec: CalibrationSpec
) -> tuple[CalibrationSpec, Joint]:
    """Calibrate from pictures, and return how, too: with which pixel aspect.

    That is the ``spec``'s, or what fits best of what the first file says that says anything. Bare methods do
    not tell how straight lines are: their pixels are square, if nobody says otherwise. Raises what
    ``calibrate_jointly`` does.
    """
    images = [picture.image for picture in pictures]
    stating = [picture for picture in pictures if stated_pixel_shape(picture.data)]
    if spec.pixel_aspect is not None or not spec.refine or not stating:
        return spec, calibrate_jointly(images, spec)
    # One picture tells it, of which that is soon done.
    tried = _tried(stating[0], spec)
    if not tried:
        return spec, calibrate_jointly(images, spec)
    best, least, _, _ = min(tried, key=lambda one: one[:2])
    spec, joint = next(
        (with_aspect, joint)
        for verdict, off, with_aspect, joint in tried
        if verdict == best and off <= AS_STRAIGHT * least
    )
    return spec, joint if len(images) == 1 else calibrate_jointly(images, spec)


def _tried(
    picture: ReadPicture, spec: CalibrationSpec
) -> list[tuple[int, float, CalibrationSpec, Joint]]:
    """Calibrate from a picture with each pixel aspect that its file may mean, the likeliest first, and 1.

    With the number of each one's verdict, and how far the lines stay from straight.
    """
    stated = stated_pixel_shape(picture.data) or Fraction(1)
    tried = []
    for aspect in (float(stated), float(1 / stated), 1.0):
        with_aspect = replace(spec, pixel_aspect=aspect)
        try:
            joint = calibrate_jointly([picture.image], with_aspect)
        except CalibrationError:
            continue
        quality = joint.calibration.quality
        if quality is not None and quality.rms is not None:
            # Where pixels count as wide, so do distances across.
            off = quality.rms / math.sqrt(aspect)
            tried.append((VERDICTS.index(quality.verdict), off, with_aspect, joint))
    return tried


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
        taken = (
            f"{made.pixel_aspect:.4f} times as wide as high" if made.pixel_aspect != 1 else "square"
        )
        if not spec.refine:
            yield f"{numbers}, which a bare method does not try: give --pixel-aspect"
        elif math.isclose(abs(math.log(stated)), abs(math.log(made.pixel_aspect)), rel_tol=1e-6):
            yield f"{numbers}: taken as {taken}, as its lines bear out"
        else:
            yield f"{numbers}, which its lines do not bear out: taken as {taken}, but for --pixel-aspect"
