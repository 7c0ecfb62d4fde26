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

Array = NDArray[np.float32]

# Lines of samples at most; a frame is thinned by nearest neighbour.
_LINES = 120
# A side of the content that is straight over this fraction of its lines is the edge of a box, not a rim. A
# circle that just fits the frame is that straight, to one sample, over a third of them.
_STRAIGHT = 0.45
# Every so many rows and columns of samples are scanned for the rim.
_ROWS, _COLUMNS = 3, 4
# Content that lasts goes on inwards for so many samples, a tenth of the lines: a ring of reflections or a
# line of text about the circle does not.
_LASTING = _LINES // 10
# By so many samples the scan finds the rim too far out, as a rule.
_WIDENING = 0.75
# Side of a corner's patch, in samples; which of them, in order, is the middle one, and which is one standard
# deviation above it.
_CORNER = 5
_SIGMA_ABOVE = 0.84
_MIDDLE, _UPPER = _CORNER**2 // 2, int(_CORNER**2 * _SIGMA_ABOVE)


class Dark(NamedTuple):
    """The outside: its level, its noise (one standard deviation), and the level that content exceeds."""

    level: float
    noise: float
    threshold: float

    @property
    def contrast(self) -> float:
        """The least rise above the outside that is no noise."""
        return least_contrast(self.noise)

    @property
    def has_glare(self) -> bool:
        """Say whether the outside is taken to be brighter than its darkest corner."""
        return self.threshold > self.level + self.contrast

    def raised(self, threshold: float) -> Dark:
        """Return the same outside with glare in it: content only counts above ``threshold``."""
        return self._replace(threshold=max(threshold, self.level + self.contrast))


def least_contrast(noise: float) -> float:
    """Return the least rise above a level with this noise that is none itself."""
    return 3 + 1.5 * noise


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
    step = -(-min(frame.size) // _LINES)
    raw = frame.luma[::step, ::step]
    if min(raw.shape) < 4 * _CORNER:
        return None
    if frame.unit > 1:
        raw = raw // np.uint16(frame.unit)
    thinned = np.ascontiguousarray(raw, dtype=np.uint8)
    values = np.asarray(cv2.blur(thinned, (3, 3)), np.uint8)
    return Samples(values, step, _dark(frame, thinned, step))


def _dark(frame: Frame, thinned: NDArray[np.uint8], step: int) -> Dark:
    """Take the outside from the darkest and evenest corner: a logo may lie over one of them.

    More of that corner's pixels than the samples tell its level and noise, whose errors would count as a
    brighter outside.
    """
    raw = thinned[_corner_places()]
    raw.sort(axis=1)
    corner = int((raw[:, _MIDDLE].astype(np.intp) + raw[:, _UPPER]).argmin())
    bottom, right = divmod(corner, 2)
    side, apart = _CORNER * step, max(step // 2, 1)
    rows = slice(-side, None, apart) if bottom else slice(0, side, apart)
    columns = slice(-side, None, apart) if right else slice(0, side, apart)
    patch = frame.luma[rows, columns].flatten()
    patch.sort()
    if frame.unit > 1:
        patch //= np.uint16(frame.unit)
    middle = float(patch[len(patch) // 2])
    # The upper side only: black is often clipped at zero, and then the lower side shows no noise. The level
    # is the mean, as that of smoothed samples, which clipped noise lifts; without marks in the corner.
    noise = max(float(patch[int(len(patch) * _SIGMA_ABOVE)]) - middle, 0.5)
    count = int(patch.searchsorted(middle + 4 * noise))
    level = float(np.add.reduce(patch[:count], dtype=np.intp)) / count
    return Dark(level, noise, level + least_contrast(noise))


@lru_cache(maxsize=1)
def _corner_places() -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the rows and columns, (4, n) each, of the samples in the four corners."""
    near = np.arange(_CORNER)
    ends = (near, near - _CORNER)
    rows = [np.repeat(end, _CORNER) for end in ends for _ in ends]
    columns = [np.tile(end, _CORNER) for _ in ends for end in ends]
    return np.stack(rows), np.stack(columns)


def first_circle(
    frame: Frame, samples: Samples, radii: tuple[float, float], lasting: bool = False
) -> tuple[Circle, Box] | None:
    """Fit a circle to where rows and columns first meet content, coming from outside; if ``lasting``, none
    that ends again soon.

    ``radii`` bounds the radius. Returns the circle and the box that holds the content (the frame, or less
    where the content is letter- or pillarboxed), both in square pixels; None without enough of a rim.
    """
    step = samples.step
    ax = frame.pixel_aspect * step
    points, edges = _scan(samples, frame.pixel_aspect, lasting)
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


def _scan(samples: Samples, pixel_aspect: float, lasting: bool) -> tuple[Array, list[int]]:
    """Return where the content begins along rows and columns, from both ends: (2, n), in square pixels.

    Straight edges of the content are left out; they come as a list: how many samples lie beyond the left,
    right, top and bottom one, 0 where there is none.
    """
    values, threshold = samples.values, samples.dark.threshold
    lit = above(values, threshold)
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


def above(values: NDArray[np.uint8], threshold: float) -> NDArray[np.bool_]:
    """Say which values exceed the threshold; comparing bytes with bytes is five times as fast."""
    return values > np.uint8(min(max(threshold, 0.0), 255.0))


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
