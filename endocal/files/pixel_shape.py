"""What a picture file says of the shape of its pixels: two numbers, of which writers make different things.

To PNG's pHYs, JFIF's densities and TIFF's resolutions they are pixels in a length, across and down: a pixel
is as wide as the second is beside the first. FFmpeg writes the reverse into PNG and JPEG files, and what a
program once wrote others keep where they make the pixels square. So they are hints, and the picture decides.
"""

from __future__ import annotations

import struct
from fractions import Fraction

from ..calibration.spec import PIXEL_ASPECTS
from ..errors import InputError
from .picture_header import JPEG, PNG, is_tiff, jpeg_markers, png_chunks, tiff_ratio

# Numbers within this share of each other are a square, rounded.
ROUNDED = 0.02
_JPEG_APP0 = 0xE0
_JFIF, _JFIF_BYTES = b"JFIF\0", 16
_ACROSS, _DOWN = 282, 283


def stated_pixel_shape(data: bytes) -> Fraction | None:
    """Return what the bytes of a whole picture file give across, over what they give down.

    A pixel's width over its height is that, or one over it. None where the file says nothing of it, or that
    pixels are square.
    """
    try:
        across, down = _numbers(data)
    except (struct.error, IndexError, InputError):
        # Broken, where no pixel is: no reason to refuse the picture.
        return None
    if not across or not down:
        return None
    ratio = across / down
    least, most = PIXEL_ASPECTS
    if abs(ratio - 1) <= ROUNDED or not least <= ratio <= most:
        return None
    return ratio


def _numbers(data: bytes) -> tuple[Fraction, Fraction]:
    nothing = Fraction(0), Fraction(0)
    if data.startswith(PNG):
        for kind, at, end in png_chunks(data):
            if kind == b"pHYs" and end - at == 9:
                across, down = struct.unpack_from(">II", data, at)
                return Fraction(across), Fraction(down)
    elif data.startswith(JPEG):
        for marker, at in jpeg_markers(data):
            if marker == _JPEG_APP0 and data.startswith(_JFIF, at + 4):
                length, _, across, down = struct.unpack_from(">H8s2H", data, at + 2)
                if length < _JFIF_BYTES:
                    break
                return Fraction(across), Fraction(down)
    elif is_tiff(data):
        return tiff_ratio(data, _ACROSS), tiff_ratio(data, _DOWN)
    return nothing
