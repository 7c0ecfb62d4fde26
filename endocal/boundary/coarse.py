"""The first look: the limit of the content, and a circle through it, on few samples."""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from .disc import Box, whole_frame
from .fit import Circle, consensus_circle
from .frame import Frame
from .outside import LINES, line_step

Array = NDArray[np.float32]

# A side of the content that is straight over this fraction of its lines is the edge of a box, not a rim. A
# circle that just fits the frame is that straight, to one sample, over a third of them.
_STRAIGHT = 0.45
# Every so many rows and columns of samples are scanned for the rim.
_ROWS, _COLUMNS = 3, 4
# Content that lasts goes on inwards for so many samples, a tenth of the lines: a ring of reflections or a
# line of text about the circle does not.
_LASTING = LINES // 10
# By so many samples the scan finds the rim too far out, as a rule.
_WIDENING = 0.75


class Samples(NamedTuple):
    """Every ``step``-th pixel of a frame, smoothed: sample [i, j] is at row i step, column j step."""

    values: NDArray[np.uint8]
    step: int


def thin(frame: Frame) -> Samples:
    """Thin a frame out."""
    step = line_step(frame)
    raw = frame.luma[::step, ::step]
    if frame.unit > 1:
        raw = raw // np.uint16(frame.unit)
    thinned = np.ascontiguousarray(raw, dtype=np.uint8)
    return Samples(np.asarray(cv2.blur(thinned, (3, 3)), np.uint8), step)


def first_circle(
    frame: Frame,
    samples: Samples,
    threshold: float,
    radii: tuple[float, float],
    lasting: bool = False,
) -> tuple[Circle, Box] | None:
    """Fit a circle to where rows and columns first meet content, coming from outside; if ``lasting``, none
    that ends again soon.

    Content is brighter than ``threshold``, of 8 bit. ``radii`` bounds the radius. Returns the circle and the
    box that holds the content (the frame, or less where the content is letter- or pillarboxed), both in
    square pixels; None without enough of a rim.
    """
    step = samples.step
    ax = frame.pixel_aspect * step
    points, edges = _scan(samples, threshold, frame.pixel_aspect, lasting)
    circle = consensus_circle(points, radii, 1.5 * step)
    if circle is None:
        return None
    # The smoothing, and a threshold near black, widen the content by this much.
    circle = circle._replace(radius=circle.radius - _WIDENING * step)
    box = whole_frame(frame.size, frame.pixel_aspect)
    if any(edges):
        h, w = samples.values.shape
        left, right, top, bottom = edges
        box = Box(
            (left - 0.5) * ax if left else box.left,
            (top - 0.5) * step if top else box.top,
            (w - right - 0.5) * ax if right else box.right,
            (h - bottom - 0.5) * step if bottom else box.bottom,
        )
    return circle, box


def _scan(
    samples: Samples, threshold: float, pixel_aspect: float, lasting: bool
) -> tuple[Array, list[int]]:
    """Return where the content begins along rows and columns, from both ends: (2, n), in square pixels.

    Straight edges of the content are left out; they come as a list: how many samples lie beyond the left,
    right, top and bottom one, 0 where there is none.
    """
    # To compare bytes with bytes is five times as fast.
    values = samples.values
    lit = values > np.uint8(min(max(threshold, 0.0), 255.0))
    upright, turned = lit[::_ROWS], np.ascontiguousarray(lit.T[::_COLUMNS])
    views = [upright, upright[:, ::-1], turned, turned[:, ::-1]]
    if lasting:
        views = [_lasting(view) for view in views]
    # Along each line, how many samples come before the first lit one, from either end.
    first = np.concatenate([lines.argmax(axis=1) for lines in views])
    # A line without content has 0 here, as one whose content touches the frame's edge; neither is a rim.
    keep = first > 1
    n, m = len(upright), len(turned)
    ends = (0, n, 2 * n, 2 * n + m, 2 * n + 2 * m)
    is_level = (first[1:] == first[:-1]) & keep[1:]
    level = np.add.reduceat(is_level, ends[:4], dtype=np.intp).tolist()
    edges = [0, 0, 0, 0]
    for side, (begin, end) in enumerate(pairwise(ends)):
        if level[side] > _STRAIGHT / 2 * (end - begin):
            edges[side] = edge = _straight_edge(first[begin:end])
            if edge:
                keep[begin:end] &= np.abs(first[begin:end] - edge) > 1
    start, way = _scan_lines(*values.shape, samples.step, pixel_aspect)
    points = way * first.astype(np.float32)
    points += start
    return points.compress(keep, axis=1), edges


@lru_cache(maxsize=4)
def _scan_lines(height: int, width: int, step: int, pixel_aspect: float) -> tuple[Array, Array]:
    """Return where each scan starts and the way that a sample is on it, (2, n) each, in square pixels."""
    rows = np.arange(0, height, _ROWS, dtype=np.float32)
    columns = np.arange(0, width, _COLUMNS, dtype=np.float32)
    across, down = np.zeros_like(rows), np.zeros_like(columns)
    start = (
        np.concatenate((across, across + (width - 1), columns, columns)),
        np.concatenate((rows, rows, down, down + (height - 1))),
    )
    way = (
        np.concatenate((across + 1, across - 1, down, down)),
        np.concatenate((across, across, down + 1, down - 1)),
    )
    pixels = np.array([[step * pixel_aspect], [step]], np.float32)
    return np.stack(start) * pixels, np.stack(way) * pixels


def _lasting(lines: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Say from which samples on a line, (n, m), the next ones are lit as well."""
    ahead = np.ones((1, _LASTING), np.uint8)
    eroded = cv2.erode(np.ascontiguousarray(lines, np.uint8), ahead, anchor=(0, 0))
    return np.asarray(eroded, np.bool_)


def _straight_edge(first: NDArray[np.intp]) -> int:
    """Return where the content begins along a straight line, or 0 where it does not."""
    counts = np.bincount(first)
    if len(counts) < 3:
        return 0
    counts[:2] = 0
    mode = int(counts.argmax())
    straight = int(counts[max(mode - 1, 0) : mode + 2].sum()) > _STRAIGHT * len(first)
    return mode if straight else 0
