"""The second look: the rim at full size along radii, to a fraction of a pixel."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from .coarse import Dark
from .disc import Box, lies_within
from .fit import Circle, fit_offsets
from .frame import Frame

Array = NDArray[np.float32]

# Radii along which the rim is looked at, evenly spread over the circle.
DIRECTIONS = 112
# Samples of a profile on each side of the expected rim, and in each of the two means that make an edge.
_REACH = 10
_MEAN = 3
# How far, in window halves, the frame must go on beyond the rim; beyond it its last pixels stand in.
_MARGIN = 0.4
# An edge nearer than this to the frame's own is that: px. Coders and converters darken the last columns.
_FRAME_EDGE = 3.0
# The residual, in robust standard deviations, at which Tukey's weight falls to 0.3.
_ACCEPTED = 3.15
# With rim points on fewer radii there is no telling.
_FEWEST = 6
_ALL = np.ones(DIRECTIONS, np.bool_)
# A peak flatter than this, in levels, is none: its place is that of its highest sample.
_LEAST_BEND = np.float32(1e-3)
_THIRDS = np.full(_MEAN, 1 / _MEAN, np.float32)


class Rim(NamedTuple):
    """What the profiles across a circle's rim showed. The counts are of radii."""

    circle: Circle
    scale: float  # px, robust standard deviation of the rim points about the circle
    radius_sigma: float  # px, of the radius, from that
    visible: int  # radii that stay in the frame
    dark: int  # of which it is dark outside
    edges: int  # of which, besides, there is a fall from content to dark
    on_circle: int  # of which the fall lies on the circle
    sharpness: float  # the fall over the middle half of the window as a share of the whole
    evidence: (
        float  # log of how much less likely so good an agreement is by chance; inf where not known
    )


@lru_cache(maxsize=1)
def directions() -> tuple[Array, Array]:
    """Return the cosines and sines of the radii."""
    # Half a step off the axes, where the frame's own edges and interlacing would meet a radius head on.
    angle = (np.arange(DIRECTIONS) + 0.5) * (2 * np.pi / DIRECTIONS)
    return np.cos(angle).astype(np.float32), np.sin(angle).astype(np.float32)


@lru_cache(maxsize=1)
def _row_starts() -> NDArray[np.intp]:
    """Where each radius begins in the flattened edges."""
    return np.arange(DIRECTIONS) * _edge_operator().shape[1]


@lru_cache(maxsize=1)
def _steps() -> Array:
    return np.arange(-_REACH, _REACH + 1, dtype=np.float32)


@lru_cache(maxsize=1)
def _edge_operator() -> Array:
    """The matrix that turns profiles into edges: mean before minus mean after each inner sample."""
    k = 2 * _REACH + 1
    inner = np.arange(_MEAN, k - _MEAN)
    operator = np.zeros((k, len(inner)), np.float32)
    for column, at in enumerate(inner):
        operator[at - _MEAN : at, column] = 1 / _MEAN
        operator[at + 1 : at + 1 + _MEAN, column] = -1 / _MEAN
    return operator


def profiles(frame: Frame, circle: Circle, offsets: Array) -> Array:
    """Sample along every radius, at ``circle.radius + offsets`` px: float32 (DIRECTIONS, len(offsets)).

    In 8-bit levels; beyond the frame its last pixels go on.
    """
    cosine, sine = directions()
    radius = offsets + np.float32(circle.radius)
    map_x = cosine[:, None] * (radius / np.float32(frame.pixel_aspect))
    map_x += np.float32(circle.x / frame.pixel_aspect)
    map_y = sine[:, None] * radius
    map_y += np.float32(circle.y)
    sampled = cv2.remap(
        frame.luma, map_x, map_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    ).astype(np.float32)
    if frame.unit > 1:
        sampled *= np.float32(1 / frame.unit)
    return sampled


def inside_box(circle: Circle, reach: float, box: Box) -> NDArray[np.bool_]:
    """Say which radii stay in the box up to ``reach`` px beyond the circle: bool (DIRECTIONS,)."""
    return _inside(circle, *directions(), np.float32(reach), box)


def _inside(
    circle: Circle, cosine: Array, sine: Array, offset: Array | np.float32, box: Box
) -> NDArray[np.bool_]:
    outer = offset + np.float32(circle.radius)
    x, y = cosine * outer, sine * outer
    return (
        (x > box.left - circle.x)
        & (x < box.right - circle.x)
        & (y > box.top - circle.y)
        & (y < box.bottom - circle.y)
    )


def look(frame: Frame, circle: Circle, half: float, box: Box, dark: Dark) -> Rim | None:
    """Fit the circle to the steepest fall from content to dark within ``half`` px of it.

    None when too few directions show such a fall.
    """
    spacing = half / _REACH
    cosine, sine = directions()
    is_whole = lies_within(circle, half + _FRAME_EDGE, box)
    seen = _ALL if is_whole else inside_box(circle, _MARGIN * half, box)
    profile = profiles(frame, circle, _steps() * np.float32(spacing))
    edges = profile @ _edge_operator()
    at = edges.argmax(axis=1)
    at = np.minimum(np.maximum(at, 1), edges.shape[1] - 2)
    # The peak, to a fraction of a sample, by a parabola through it and its neighbours.
    flat, place = edges.ravel(), at + _row_starts()
    before, middle, after = flat.take(place - 1), flat.take(place), flat.take(place + 1)
    bend = middle - before
    bend += middle
    bend -= after
    offset = (after - before) / np.maximum(bend, _LEAST_BEND)
    offset *= np.float32(0.5)
    offset += at.astype(np.float32)
    offset += _MEAN - _REACH
    offset *= np.float32(spacing)
    outside = profile[:, -_MEAN:] @ _THIRDS
    is_dark = seen & (outside < dark.threshold + dark.noise)
    is_rim = is_dark & (middle > dark.contrast)
    if not is_whole:
        is_rim &= _inside(circle, cosine, sine, offset + np.float32(_FRAME_EDGE), box)
    usable = np.flatnonzero(is_rim)
    if len(usable) < _FEWEST:
        return None
    fitted = fit_offsets(cosine[usable], sine[usable], offset[usable], 0.25 * spacing, half / 3)
    if fitted is None:
        return None
    moved = Circle(circle.x + fitted.by.x, circle.y + fitted.by.y, circle.radius + fitted.by.radius)
    count = int(np.count_nonzero(fitted.weight > 0.3))
    # An edge that has nothing to do with the circle lies anywhere in the window; on the circle it lies
    # within the width that the weights accept.
    gain = (half - _MEAN * spacing) / (_ACCEPTED * fitted.scale)
    return Rim(
        moved,
        fitted.scale,
        fitted.radius_sigma,
        int(np.count_nonzero(seen)),
        int(np.count_nonzero(is_dark)),
        len(usable),
        count,
        _sharpness(is_rim.astype(np.float32) @ profile),
        count * math.log(gain),
    )


def _sharpness(profile: Array) -> float:
    """Return the fall over the middle half as a share of the whole: 1 for a step, a half for a slope."""
    first, second, third, last = (profile @ _quarters()).tolist()
    return (second - third) / (first - last) if first > last else 0.0


@lru_cache(maxsize=1)
def _quarters() -> Array:
    """The matrix that turns a profile into its means at both ends and about its quarters."""
    samples = 2 * _REACH + 1
    operator = np.zeros((samples, 4), np.float32)
    starts = (0, _REACH // 2, samples - _REACH // 2 - _MEAN, samples - _MEAN)
    for column, start in enumerate(starts):
        operator[start : start + _MEAN, column] = 1 / _MEAN
    return operator
