"""A picture before and after correction, side by side, with a grid that correction makes straight."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from ..model import DivisionModel
from ..remap.geometry import OutputGeometry

Picture = NDArray[np.uint8]
Points = NDArray[np.float64]

# Cells of the grid across the corrected picture, and points that a line is drawn through.
CELLS, _POINTS = 12, 400
_COLOUR, _OUTLINE = (160, 255, 64), (0, 0, 0)  # BGR; tissue has neither
_STRENGTHS = {_OUTLINE: 0.4, _COLOUR: 0.9}
_GROUND, _INK = (32, 32, 32), (240, 240, 240)
_SUBPIXEL_BITS = 4


def before_after(
    before: Picture, after: Picture, model: DivisionModel, geometry: OutputGeometry, words: str
) -> Picture:
    """Return both (h, w, 3) BGR pictures beside each other under their titles, the grid on each.

    ``before`` is the frame and ``after`` what ``geometry`` shows of it through ``model``; ``words`` go with
    the second title. A frame whose pixels are not square is stretched where the output's are.
    """
    straight = _grid(geometry)
    undistorted = [np.array(geometry.origin) + np.array(geometry.step) * line for line in straight]
    stretch = model.pixel_aspect / geometry.pixel_aspect
    w, h = model.size
    if stretch != 1:
        size = (round(w * stretch), h)
        before = np.asarray(cv2.resize(before, size, interpolation=cv2.INTER_LINEAR), np.uint8)
    bent = [_stretched(model.distort(line), before.shape[1] / w) for line in undistorted]
    panels = [
        _titled(_with_lines(before, bent), "before"),
        _titled(_with_lines(after, straight), f"after: {words}" if words else "after"),
    ]
    height, gap = max(p.shape[0] for p in panels), max(4, before.shape[1] // 100)
    padded = []
    for panel, right in zip(panels, (gap, 0), strict=True):
        below = height - panel.shape[0]
        padded.append(
            cv2.copyMakeBorder(panel, 0, below, 0, right, cv2.BORDER_CONSTANT, value=_GROUND)
        )
    return np.asarray(np.hstack(padded), np.uint8)


def _grid(geometry: OutputGeometry) -> list[Points]:
    """The lines (n, 2) of a square grid over the output, px, none on its border."""
    w, h = geometry.size
    step = w / CELLS
    columns = w / 2 + step * np.arange(-(CELLS // 2) + 1, CELLS // 2)
    rows = h / 2 + step * np.arange(-int(h / 2 / step), int(h / 2 / step) + 1)
    along_x, along_y = np.linspace(0, w - 1, _POINTS), np.linspace(0, h - 1, _POINTS)
    lines = [np.stack([np.full(_POINTS, x - 0.5), along_y], axis=1) for x in columns]
    return lines + [
        np.stack([along_x, np.full(_POINTS, y - 0.5)], axis=1) for y in rows if 1 < y < h - 1
    ]


def _stretched(points: Points, factor: float) -> Points:
    """Move points by pixel centres to a picture that is so much wider."""
    return np.stack([(points[:, 0] + 0.5) * factor - 0.5, points[:, 1]], axis=1)


def _with_lines(picture: Picture, lines: list[Points]) -> Picture:
    h, w = picture.shape[:2]
    out = picture
    width = max(1, round(h / 540))
    pieces = [piece for line in lines for piece in _pieces(line, w, h)]
    for colour, extra in ((_OUTLINE, 1), (_COLOUR, 0)):
        drawn, strength = out.copy(), _STRENGTHS[colour]
        cv2.polylines(drawn, pieces, False, colour, width + extra, cv2.LINE_AA, _SUBPIXEL_BITS)
        out = np.asarray(cv2.addWeighted(drawn, strength, out, 1 - strength, 0), np.uint8)
    return out


def _pieces(line: Points, w: int, h: int) -> list[Any]:
    """The parts of a line that lie in the picture, in fixed point; where nothing maps there is no line."""
    with np.errstate(invalid="ignore"):
        inside = ((line >= -1) & (line <= (w, h))).all(axis=1)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], inside, [False]]).astype(np.int8)))
    fixed = 1 << _SUBPIXEL_BITS
    return [
        np.rint(line[a:b] * fixed).astype(np.int32) for a, b in edges.reshape(-1, 2) if b - a > 1
    ]


def _titled(picture: Picture, title: str) -> Picture:
    """Put a title above a picture."""
    h, w = picture.shape[:2]
    size = max(0.45, min(h / 900, 1.6))
    bar = np.full((round(44 * size), w, 3), _GROUND, np.uint8)
    place = (round(10 * size), round(30 * size))
    cv2.putText(bar, title, place, cv2.FONT_HERSHEY_SIMPLEX, 0.8 * size, _INK, 1, cv2.LINE_AA)
    return np.vstack([bar, picture])
