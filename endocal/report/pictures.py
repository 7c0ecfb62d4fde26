"""Pictures in a page: JPEG of moderate size, with lines drawn on them in colours that tell a number."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from ..calibration.straightness import Floats, Labels
from ..model import DivisionModel
from ..remap.remapper import Remapper
from .page import Html, image

Picture = NDArray[np.uint8]

# Pictures are shown this wide, px, or enlarged so many times if that is less.
SHOWN_WIDTH, MOST_ENLARGED = 1280, 2.0
QUALITY = 82
# Beneath lines a picture is paler, so that they stand out from black and white alike.
PALENESS = 0.5
# Colours of lines by the size of what they show, from small to large, and those past the end of the scale.
LINE_COLOURS = ("#2f7df0", "#12b886", "#f5b301", "#e8302a")
# Points farther apart than this along a line, px, are not joined.
_GAP = 14.0
_SUBPIXEL_BITS = 4


def to_show(picture: NDArray[Any], pixel_aspect: float = 1.0) -> tuple[Picture, float]:
    """Return a picture (h, w[, 3]) of 8 or 16 bits as (h', w', 3) BGR of square pixels, and its scale.

    The scale is shown px per px of the frame's height.
    """
    if picture.dtype == np.uint16:
        picture = (picture >> 8).astype(np.uint8)
    shown: Any = picture if picture.ndim == 3 else cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR)
    h, w = shown.shape[:2]
    scale = min(MOST_ENLARGED, SHOWN_WIDTH / (w * pixel_aspect))
    size = (round(w * pixel_aspect * scale), round(h * scale))
    how = cv2.INTER_AREA if scale < 1 else cv2.INTER_CUBIC
    return np.asarray(cv2.resize(shown[..., :3], size, interpolation=how), np.uint8), scale


def places(points: Floats, pixel_aspect: float) -> Floats:
    """Where points (..., 2) in square pixels lie in a picture from ``to_show``, before its scale.

    The first pixel's centre is their 0; that picture widens a pixel about its left edge.
    """
    return points + np.array([(pixel_aspect - 1) / 2, 0.0])


def corrected(shown: Picture, model: DivisionModel) -> Picture:
    """Return a picture from ``to_show`` without the distortion of ``model``."""
    h, w = shown.shape[:2]
    square = _in_square_pixels(model)
    scale = h / model.size[1]
    cx, cy = square.center
    scaled = DivisionModel(
        square.lam / scale**2,
        ((cx + 0.5) * scale - 0.5, (cy + 0.5) * scale - 0.5),
        (w, h),
        1.0,
        square.lam2 / scale**4,
    )
    return np.asarray(Remapper(scaled, device="numpy").apply(shown), np.uint8)


def with_lines(
    shown: Picture, scale: float, points: Floats, labels: Labels, classes: Labels
) -> Picture:
    """Draw the lines through points (n, 2), px of the frame's height, in their order by ``labels`` (n,).

    ``classes`` (n,) picks each point's colour from LINE_COLOURS; higher ones are drawn over lower ones.
    """
    out = np.asarray(255 - PALENESS * (255 - shown.astype(np.float32)), np.uint8)
    at = np.rint(((points + 0.5) * scale - 0.5) * (1 << _SUBPIXEL_BITS)).astype(np.int32)
    joined = (labels[1:] == labels[:-1]) & (np.linalg.norm(np.diff(points, axis=0), axis=1) < _GAP)
    worse = np.maximum(classes[1:], classes[:-1])
    for number, colour in enumerate(LINE_COLOURS):
        chosen = np.nonzero(joined & (worse == number))[0]
        pieces = np.stack([at[chosen], at[chosen + 1]], axis=1)
        cv2.polylines(
            out, list(pieces), False, _bgr(colour), 2 + (number > 1), cv2.LINE_AA, _SUBPIXEL_BITS
        )
    return out


def with_mark(shown: Picture, place: tuple[float, float], scale: float) -> Picture:
    """Draw a cross at (x, y), px of the frame's height."""
    x, y = (round((v + 0.5) * scale - 0.5) for v in place)
    out = shown.copy()
    for colour, width in ((_bgr("#ffffff"), 6), (_bgr("#b0126f"), 2)):
        cv2.drawMarker(out, (x, y), colour, cv2.MARKER_CROSS, 28, width, cv2.LINE_AA)
    return out


def as_image(shown: Picture, alt: str) -> Html:
    """Return the picture as a part of a page."""
    options = [
        *(cv2.IMWRITE_JPEG_QUALITY, QUALITY),
        *(cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444),
    ]
    data = cv2.imencode(".jpg", shown, options)[1].tobytes()
    return image(data, "jpeg", alt, (shown.shape[1], shown.shape[0]))


def _in_square_pixels(model: DivisionModel) -> DivisionModel:
    aspect = model.pixel_aspect
    size = (round(model.size[0] * aspect), model.size[1])
    x, y = places(np.array(model.center) * (aspect, 1.0), aspect)
    return DivisionModel(model.lam, (x, y), size, 1.0, model.lam2)


def _bgr(colour: str) -> tuple[int, int, int]:
    r, g, b = bytes.fromhex(colour[1:])
    return b, g, r
