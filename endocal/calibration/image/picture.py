"""The picture as calibration sees it: one grey plane, its content, and its fields where it is interlaced.

From here on a pixel is square: x is multiplied by the pixel aspect, and everything is in px of the
frame's height.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from ...errors import InputError

Image = NDArray[np.uint8] | NDArray[np.uint16]
Grey = NDArray[np.float32]
Mask = NDArray[np.bool_]

# Two fields that lie further apart than this, in px, are measured one by one; nearer ones blur an edge
# evenly to both sides and lose nothing together.
COMB_SHIFT = 0.2
# Of larger pictures, so many pixels tell how far their fields lie apart: bands of so many rows, an even
# number.
SAMPLED_PIXELS, BAND = 2_500_000, 32
# A frame below this many px a side holds no line worth measuring.
SMALLEST = 64


@dataclass(frozen=True)
class Picture:
    """``grey`` (h, w) in grey levels 0 to 255; ``content`` (h, w): where edges may be looked for.

    ``beyond`` (h, w): where they may be looked for once a model tells which are straight.
    """

    grey: Grey
    content: Mask
    beyond: Mask | None = None


def checked(image: Image) -> Image:
    """Return a picture as a uint8 or uint16 array of this machine's byte order, (h, w) or (h, w, 3) BGR.

    Taken are uint8 and uint16 of any byte order, (h, w) or (h, w, 1) grey, (h, w, 3) BGR, and (h, w, 4) BGRA,
    whose alpha is ignored. Raises InputError for anything else, and for a frame too small to hold a line.
    """
    channels = image.shape[2] if image.ndim == 3 else 1
    deep = image.dtype.kind == "u" and image.dtype.itemsize <= 2
    if not deep or image.ndim not in (2, 3) or channels not in (1, 3, 4):
        raise InputError(
            f"the picture is {image.dtype} {image.shape}; uint8 or uint16 is needed, (h, w) grey or"
            " (h, w, 3) BGR"
        )
    if min(image.shape[:2]) < SMALLEST:
        raise InputError(
            f"the picture is {image.shape[1]}x{image.shape[0]}: too small, {SMALLEST} px a side is the least"
        )
    if image.ndim == 3:
        image = image[..., 0] if channels == 1 else image[..., :3]
    return np.asarray(image, np.uint8) if image.itemsize == 1 else np.asarray(image, np.uint16)


def to_grey(image: Image) -> Grey:
    """Turn a picture, any that ``checked`` takes, into grey levels (h, w) from 0 to 255.

    Of 16 bits, those above the lightest pixel's do not count: cameras write 10 or 12 into the lower ones.
    Raises InputError for another shape or type, or a frame too small to hold a line.
    """
    image = checked(image)
    grey = (
        image if image.ndim == 2 else cv2.cvtColor(np.ascontiguousarray(image), cv2.COLOR_BGR2GRAY)
    )
    if grey.dtype == np.uint8:
        return np.asarray(grey, np.float32)
    bits = max(int(grey.max()).bit_length(), 8)
    return np.asarray(grey, np.float32) * np.float32(255.0 / (2**bits - 1))


def fields(grey: Grey) -> list[Grey]:
    """Split a picture whose two fields were taken apart; a progressive one comes back whole.

    Each field is given at full height, its missing rows interpolated, so that coordinates stay those of
    the frame.
    """
    if abs(field_shift(grey)) < COMB_SHIFT:
        return [grey]
    return [_line_doubled(grey, parity) for parity in (0, 1)]


def field_shift(grey: Grey) -> float:
    """Return how far the odd rows lie to the right of the even ones, in px, by least squares.

    Only where a strong vertical edge makes the shift plain; rows of both parities are compared with the
    mean of the rows above and below them, so that a slanted edge adds nothing.
    """
    smooth = _bands(np.asarray(cv2.blur(grey, (3, 1)), np.float32))
    rows = smooth[:, 1:-1]
    between = smooth[:, :-2] + smooth[:, 2:]
    between *= 0.5
    middle = rows + between
    middle *= 0.5
    slope = np.zeros(rows.shape, np.float32)
    np.subtract(middle[..., 2:], middle[..., :-2], out=slope[..., 1:-1])
    slope *= 0.5
    size = np.abs(slope, out=middle)
    least = max(4.0, 0.5 * float(np.percentile(size, 98)))
    strong = np.nonzero(size > least)
    slopes = slope[strong]
    weight = float((slopes**2).sum())
    if weight == 0:
        return 0.0
    difference = rows[strong] - between[strong]
    # For even rows the neighbours are the odd field; the first row of a band here is its second.
    difference[strong[1] % 2 == 1] *= -1
    return -float((difference * slopes).sum()) / weight


def _bands(grey: Grey) -> Grey:
    """The picture as one band of rows, (1, h, w); a large one as some of its bands, (b, BAND, w)."""
    if grey.size <= SAMPLED_PIXELS:
        return grey[None]
    h, w = grey.shape
    bands = grey[: h // BAND * BAND].reshape(-1, BAND, w)
    return bands[:: -(-grey.size // SAMPLED_PIXELS)]


def _line_doubled(grey: Grey, parity: int) -> Grey:
    out = grey.copy()
    rows = np.arange(1 - parity, grey.shape[0], 2)
    above, below = np.clip(rows - 1, 0, None), np.clip(rows + 1, None, grey.shape[0] - 1)
    above = np.where(rows == 0, 1, above)
    below = np.where(rows == grey.shape[0] - 1, grey.shape[0] - 2, below)
    out[rows] = (grey[above] + grey[below]) / 2
    return out
