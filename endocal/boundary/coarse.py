"""The first look: the black outside, the limit of the content, and a circle through it, on few samples."""

from __future__ import annotations

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
    corners = np.sort(corners.reshape(4, k * k), axis=1).astype(np.float32)
    middle, upper = corners[:, k * k // 2], corners[:, int(k * k * 0.84)]
    best = int((middle + upper).argmin())
    level = float(middle[best])
    # The upper side only: black is often clipped at zero, and then the lower side shows no noise.
    noise = max(float(upper[best]) - level, 0.5)
    return Dark(level, noise, 0.0).raised(0.0)


def first_circle(
    frame: Frame, samples: Samples, radii: tuple[float, float]
) -> tuple[Circle, Box] | None:
    """Fit a circle to where rows and columns first meet content, coming from outside.

    ``radii`` bounds the radius. Returns the circle and the box that holds the content (the frame, or less
    where the content is letter- or pillarboxed), both in square pixels; None without enough of a rim.
    """
    values, step, dark = samples.values, samples.step, samples.dark
    h, w = values.shape
    lit = values > dark.threshold
    rows, columns = np.arange(0, h, 2), np.arange(0, w, 3)
    across, down = lit[::2], np.ascontiguousarray(lit[:, ::3].T)
    left, right = _outermost(across)
    top, bottom = _outermost(down)
    x0, keep_left = _side(left)
    x1, keep_right = _side(right)
    y0, keep_top = _side(top)
    y1, keep_bottom = _side(bottom)
    x = np.concatenate(
        (left[keep_left], w - 1 - right[keep_right], columns[keep_top], columns[keep_bottom])
    )
    y = np.concatenate(
        (rows[keep_left], rows[keep_right], top[keep_top], h - 1 - bottom[keep_bottom])
    )
    ax = np.float32(frame.pixel_aspect * step)
    circle = consensus_circle(
        x.astype(np.float32) * ax, y.astype(np.float32) * np.float32(step), radii, 1.5 * step
    )
    if circle is None:
        return None
    whole = whole_frame(frame.size, frame.pixel_aspect)
    box = Box(
        (x0 - 0.5) * float(ax) if x0 else whole.left,
        (y0 - 0.5) * step if y0 else whole.top,
        (w - x1 - 0.5) * float(ax) if x1 else whole.right,
        (h - y1 - 0.5) * step if y1 else whole.bottom,
    )
    return circle, box


def _outermost(lit: NDArray[np.bool_]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return per row how many samples come before the first lit one, from the left and from the right."""
    return lit.argmax(axis=1), lit[:, ::-1].argmax(axis=1)


def _side(first: NDArray[np.intp]) -> tuple[int, NDArray[np.bool_]]:
    """Tell rim points from a straight edge: where the edge is, and which lines' first samples to keep.

    A line without content has 0 here, as one whose content touches the frame's edge; neither is a rim.
    """
    keep = first > 1
    met = first[keep]
    if len(met) < 4:
        return 0, keep
    counts = np.bincount(met)
    mode = int(counts.argmax())
    if counts[max(mode - 1, 0) : mode + 2].sum() > _STRAIGHT * len(first):
        keep &= np.abs(first - mode) > 1
        return mode, keep
    return 0, keep
