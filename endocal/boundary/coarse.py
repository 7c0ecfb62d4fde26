"""The first look: the black outside, the limit of the content, and a circle through it, on few samples."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from .disc import Box, whole_frame
from .fit import Circle, consensus_circle
from .frame import Frame

# Lines of samples to aim at; a frame is thinned by nearest neighbour to about this height.
_LINES = 135
# A side of the content that is straight over this fraction of its lines is the edge of a box, not a rim. A
# circle that just fits the frame is that straight, to one sample, over a third of them.
_STRAIGHT = 0.45
# Every so many rows and columns of samples are scanned for the rim.
_ROWS, _COLUMNS = 2, 3
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
    return Samples(values, step, _dark(thinned))


def _dark(thinned: NDArray[np.uint8]) -> Dark:
    """Take the outside from the darkest and evenest corner: a logo may lie over one of them."""
    k = _CORNER
    corners = np.stack([thinned[:k, :k], thinned[:k, -k:], thinned[-k:, :k], thinned[-k:, -k:]])
    corners = corners.reshape(4, k * k)
    corners.sort(axis=1)
    middle, upper = (corners[:, i].tolist() for i in (k * k // 2, int(k * k * 0.84)))
    # The upper side only: black is often clipped at zero, and then the lower side shows no noise.
    total, level = min((m + u, m) for m, u in zip(middle, upper, strict=True))
    return Dark(float(level), max(total - 2.0 * level, 0.5), 0.0).raised(0.0)


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
    threshold = samples.dark.threshold
    # Along each line, how many samples come before the first lit one, from either end.
    sides = [
        (lines > threshold).argmax(axis=1)
        for lines in (upright, cv2.flip(upright, 1), turned, cv2.flip(turned, 1))
    ]
    edges = [_straight_edge(first) for first in sides]
    rows, columns = _lines(h, w)
    x = np.concatenate((sides[0], w - 1 - sides[1], columns, columns), dtype=np.float32)
    y = np.concatenate((rows, rows, sides[2], h - 1 - sides[3]), dtype=np.float32)
    # A line without content has 0 here, as one whose content touches the frame's edge; neither is a rim.
    keep = np.concatenate(
        [f > 1 if e == 0 else (f > 1) & (abs(f - e) > 1) for f, e in zip(sides, edges, strict=True)]
    )
    ax = frame.pixel_aspect * step
    x, y = x[keep] * np.float32(ax), y[keep] * np.float32(step)
    circle = consensus_circle(x, y, radii, 1.5 * step)
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
def _lines(height: int, width: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The rows and the columns that are scanned."""
    return np.arange(0, height, _ROWS), np.arange(0, width, _COLUMNS)


def _straight_edge(first: NDArray[np.intp]) -> int:
    """Return where the content begins along a straight line, or 0 where it does not."""
    counts = np.bincount(first)
    if len(counts) < 3:
        return 0
    counts[:2] = 0
    mode = int(counts.argmax())
    straight = int(counts[max(mode - 1, 0) : mode + 2].sum()) > _STRAIGHT * len(first)
    return mode if straight else 0
