"""The first look: the black outside, the limit of the content, and a circle through it, on few samples."""

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

# Lines of samples to aim at; a frame is thinned by nearest neighbour to about this height.
_LINES = 120
# A side of the content that is straight over this fraction of its lines is the edge of a box, not a rim. A
# circle that just fits the frame is that straight, to one sample, over a third of them.
_STRAIGHT = 0.45
Array = NDArray[np.float32]

# Every so many rows and columns of samples are scanned for the rim.
_ROWS, _COLUMNS = 3, 4
# By so many samples the scan finds the rim too far out, as a rule.
_WIDENING = 0.75
# Side of a corner's patch, in samples.
_CORNER = 5


class Dark(NamedTuple):
    """The outside: its level, its noise (one standard deviation), and the level that content exceeds."""

    level: float
    noise: float
    threshold: float

    @property
    def contrast(self) -> float:
        """The least rise above the outside that is no noise."""
        return 3 + 1.5 * self.noise

    @property
    def has_glare(self) -> bool:
        """Say whether the outside is taken to be brighter than its darkest corner."""
        return self.threshold > self.level + self.contrast

    def raised(self, threshold: float) -> Dark:
        """Return the same outside with glare in it: content only counts above ``threshold``."""
        return self._replace(threshold=max(threshold, self.level + self.contrast))


class Samples(NamedTuple):
    """Every ``step``-th pixel of a frame, smoothed: sample [i, j] is at row i step, column j step."""

    values: NDArray[np.uint8]
    step: int
    dark: Dark


def thin(frame: Frame) -> Samples | None:
    """Thin the frame out and find the black outside; None for a frame of few px.

    A circle that leaves anything outside it in the frame leaves a corner outside, since the corners'
    convex hull is the frame.
    """
    step = max(1, round(min(frame.size) / _LINES))
    raw = frame.luma[::step, ::step]
    if min(raw.shape) < 4 * _CORNER:
        return None
    if frame.unit > 1:
        raw = raw // np.uint16(frame.unit)
    thinned = np.ascontiguousarray(raw, dtype=np.uint8)
    values = np.asarray(cv2.blur(thinned, (3, 3)), np.uint8)
    return Samples(values, step, _dark(thinned, values))


def _dark(thinned: NDArray[np.uint8], values: NDArray[np.uint8]) -> Dark:
    """Take the outside from the darkest and evenest corner: a logo may lie over one of them."""
    places = _corner_places()
    raw, smoothed = thinned[places], values[places]
    raw.sort(axis=1)
    smoothed.sort(axis=1)
    count = raw.shape[1]
    middle, upper = raw[:, count // 2].tolist(), raw[:, int(count * 0.84)].tolist()
    best = min(range(4), key=lambda corner: middle[corner] + upper[corner])
    # The upper side only: black is often clipped at zero, and then the lower side shows no noise. The level
    # is that of smoothed samples, which clipped noise lifts.
    noise = max(float(upper[best] - middle[best]), 0.5)
    return Dark(float(smoothed[best, count // 2]), noise, 0.0).raised(0.0)


@lru_cache(maxsize=1)
def _corner_places() -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the rows and columns, (4, n) each, of the samples in the four corners."""
    near = np.arange(_CORNER)
    ends = (near, near - _CORNER)
    rows = [np.repeat(end, _CORNER) for end in ends for _ in ends]
    columns = [np.tile(end, _CORNER) for _ in ends for end in ends]
    return np.stack(rows), np.stack(columns)


def first_circle(
    frame: Frame, samples: Samples, radii: tuple[float, float]
) -> tuple[Circle, Box] | None:
    """Fit a circle to where rows and columns first meet content, coming from outside.

    ``radii`` bounds the radius. Returns the circle and the box that holds the content (the frame, or less
    where the content is letter- or pillarboxed), both in square pixels; None without enough of a rim.
    """
    values, step = samples.values, samples.step
    h, w = values.shape
    upright = np.ascontiguousarray(values[::_ROWS])
    turned = np.ascontiguousarray(cv2.transpose(values)[::_COLUMNS])
    # Along each line, how many samples come before the first lit one, from either end.
    firsts = [
        above(np.concatenate((lines, cv2.flip(lines, 1))), samples.dark.threshold).argmax(axis=1)
        for lines in (upright, turned)
    ]
    first = np.concatenate(firsts).astype(np.float32)
    # A line without content has 0 here, as one whose content touches the frame's edge; neither is a rim.
    keep = first > 1
    n, m = len(upright), len(turned)
    bounds = (0, n, 2 * n, 2 * n + m, 2 * n + 2 * m)
    is_level = first[1:] == first[:-1]
    edges = [0, 0, 0, 0]
    for side, (begin, end) in enumerate(pairwise(bounds)):
        if np.count_nonzero(is_level[begin : end - 1]) > _STRAIGHT / 2 * (end - begin):
            edges[side] = edge = _straight_edge(first[begin:end])
            if edge:
                keep[begin:end] &= np.abs(first[begin:end] - edge) > 1
    lines_x, lines_y, sign_x, sign_y = _scan_lines(h, w)
    x, y = lines_x + sign_x * first, lines_y + sign_y * first
    ax = frame.pixel_aspect * step
    circle = consensus_circle(
        x[keep] * np.float32(ax), y[keep] * np.float32(step), radii, 1.5 * step
    )
    if circle is None:
        return None
    # The smoothing, and a threshold near black, widen the content by this much.
    circle = circle._replace(radius=circle.radius - _WIDENING * step)
    whole = whole_frame(frame.size, frame.pixel_aspect)
    box = Box(
        (edges[0] - 0.5) * ax if edges[0] else whole.left,
        (edges[2] - 0.5) * step if edges[2] else whole.top,
        (w - edges[1] - 0.5) * ax if edges[1] else whole.right,
        (h - edges[3] - 0.5) * step if edges[3] else whole.bottom,
    )
    return circle, box


@lru_cache(maxsize=4)
def _scan_lines(height: int, width: int) -> tuple[Array, Array, Array, Array]:
    """Return where each scan starts, x and y, and the direction in which it goes."""
    rows = np.arange(0, height, _ROWS, dtype=np.float32)
    columns = np.arange(0, width, _COLUMNS, dtype=np.float32)
    across, down = np.zeros_like(rows), np.zeros_like(columns)
    return (
        np.concatenate((across, across + (width - 1), columns, columns)),
        np.concatenate((rows, rows, down, down + (height - 1))),
        np.concatenate((across + 1, across - 1, down, down)),
        np.concatenate((across, across, down + 1, down - 1)),
    )


def above(values: NDArray[np.uint8], threshold: float) -> NDArray[np.bool_]:
    """Say which values exceed the threshold; comparing bytes with bytes is five times as fast."""
    return values > np.uint8(min(max(threshold, 0.0), 255.0))


def _straight_edge(first: Array) -> int:
    """Return where the content begins along a straight line, or 0 where it does not."""
    counts = np.bincount(first.astype(np.intp))
    if len(counts) < 3:
        return 0
    counts[:2] = 0
    mode = int(counts.argmax())
    straight = int(counts[max(mode - 1, 0) : mode + 2].sum()) > _STRAIGHT * len(first)
    return mode if straight else 0
