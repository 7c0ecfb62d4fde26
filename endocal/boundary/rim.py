"""The second look: the rim at full size along radii, to a fraction of a pixel."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from .departure import RimPoints
from .disc import Box, lies_within, whole_frame
from .fit import Circle, bearings, fit_offsets
from .frame import Frame
from .outside import Dark

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
# Samples between two circles, along every so manieth radius. What is brighter than the last, in levels over
# black, is no noise.
_BETWEEN, _SKIPPED, _PLAIN_LEVEL = 48, 4, 12.0
# Samples of a profile, and edges in it.
_SAMPLES = 2 * _REACH + 1
_EDGES = _SAMPLES - 2 * _MEAN
# The parabola's top lies between the peak's neighbours, in samples.
_NEXT = (np.float32(-1), np.float32(1))
# What turns three neighbours into the slope and the bend of the parabola through them.
_PARABOLA = np.array([[-0.5, 0, 0.5], [-1, 2, -1]], np.float32)


class Rim(NamedTuple):
    """What the profiles across a circle's rim showed. The counts are of radii."""

    circle: Circle
    scale: float  # px, robust standard deviation of the rim points about the circle
    radius_sigma: float  # px, of the radius, from that
    center_sigma: float  # px, of the centre, likewise
    visible: int  # radii that stay in the frame
    dark: int  # of which it is dark outside
    edges: int  # of which, besides, there is a fall from content to dark
    on_circle: int  # of which the fall lies on the circle
    sharpness: float  # the fall over the middle half of the window as a share of the whole
    evidence: float  # natural log of the odds against so good an agreement by chance
    points: RimPoints  # what the circle was fitted to


@lru_cache(maxsize=2)
def angles(count: int = DIRECTIONS) -> Array:
    """Return the angles of ``count`` radii, in radians."""
    # Half a step off the axes, where the frame's own edges and interlacing would meet a radius head on.
    return ((np.arange(count) + 0.5) * (2 * np.pi / count)).astype(np.float32)


@lru_cache(maxsize=2)
def directions(count: int = DIRECTIONS) -> tuple[Array, Array]:
    """Return the cosines and sines of ``count`` radii."""
    return np.cos(angles(count)), np.sin(angles(count))


@lru_cache(maxsize=1)
def all_bearings() -> Array:
    """The bearings, (9, DIRECTIONS), that a circle's shift is fitted with."""
    return bearings(angles())


@lru_cache(maxsize=1)
def _window() -> Array:
    """The places of all samples about a circle's rim, as what its figures have to be multiplied with.

    (4, 2 _SAMPLES DIRECTIONS): per x, y, radius and the samples' spacing; first all x, then all y.
    """
    cosine_sine = np.stack(directions())[:, None]
    shape = (2, _SAMPLES, DIRECTIONS)
    places = np.zeros((4, *shape), np.float32)
    places[0, 0] = places[1, 1] = 1
    places[2] = cosine_sine
    places[3] = cosine_sine * np.arange(-_REACH, _REACH + 1)[:, None]
    return places.reshape(4, -1)


@lru_cache(maxsize=1)
def _readings() -> Array:
    """The matrix that turns profiles, (_SAMPLES, n), into what is read from them, (n, _EDGES + 5).

    First the edges: mean before minus mean after each inner sample. Then the mean outside. Then the means at
    both ends and about the quarters: begin, first quarter, last quarter, end.
    """
    operator = np.zeros((_SAMPLES, _EDGES + 5), np.float32)
    for column in range(_EDGES):
        operator[column : column + _MEAN, column] = 1 / _MEAN
        operator[column + _MEAN + 1 : column + 2 * _MEAN + 1, column] = -1 / _MEAN
    quarter = _REACH // 2
    starts = (_SAMPLES - _MEAN, 0, quarter, _SAMPLES - quarter - _MEAN, _SAMPLES - _MEAN)
    for column, start in enumerate(starts, _EDGES):
        operator[start : start + _MEAN, column] = 1 / _MEAN
    return operator


@lru_cache(maxsize=1)
def _around() -> NDArray[np.intp]:
    """Where in the flattened readings the first edge, its neighbours before and after it, are: (3, n)."""
    row = np.arange(DIRECTIONS) * (_EDGES + 5)
    return row + np.arange(3)[:, None]


@lru_cache(maxsize=1)
def _edge_places() -> Array:
    """Where each of the edges that count is, in samples from the expected rim."""
    return np.arange(1, _EDGES - 1, dtype=np.float32) + np.float32(_MEAN - _REACH)


def profiles(frame: Frame, circle: Circle, offsets: Array, along: tuple[Array, Array]) -> Array:
    """Sample at ``circle.radius + offsets`` px ``along`` radii, cosines and sines (n,) of their angles.

    ``offsets`` are (m, 1). Returns float32 (m, n) in 8-bit levels; beyond the frame its last pixels go on.
    """
    return _sampled(frame, *_places(circle, offsets + np.float32(circle.radius), *along))


def _places(circle: Circle, radius: Array, cosine: Array, sine: Array) -> tuple[Array, Array]:
    """Return x and y, square pixels, at these radii from the circle's centre."""
    x, y = cosine * radius, sine * radius
    x += np.float32(circle.x)
    y += np.float32(circle.y)
    return x, y


def _window_profiles(frame: Frame, circle: Circle, spacing: float) -> Array:
    """Sample as ``profiles`` does, at the window's samples along all directions: (_SAMPLES, DIRECTIONS)."""
    figures = np.array((circle.x, circle.y, circle.radius, spacing), np.float32)
    x, y = (figures @ _window()).reshape(2, _SAMPLES, DIRECTIONS)
    return _sampled(frame, x, y)


def _sampled(frame: Frame, x: Array, y: Array) -> Array:
    """Return the frame's levels, of 8 bit, at these places, square pixels; changes ``x``."""
    if frame.pixel_aspect != 1:
        x *= np.float32(1 / frame.pixel_aspect)
    sampled = cv2.remap(frame.luma, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE).astype(
        np.float32
    )
    if frame.unit > 1:
        sampled *= np.float32(1 / frame.unit)
    return sampled


def dips_between(frame: Frame, inner: Circle, outer: Circle, black: float) -> float:
    """Return on which share of the radii a dark gap lies between two circles, the one inside the other.

    There the picture, over its ``black`` (8-bit levels), falls to half and less of what follows further out.
    Only radii that stay in the frame count.
    """
    cosine, sine = (v[::_SKIPPED] for v in directions())
    # Where a radius from the inner circle's centre meets the outer circle.
    dx, dy = inner.x - outer.x, inner.y - outer.y
    across, along = dx * sine - dy * cosine, dx * cosine + dy * sine
    width = np.sqrt(outer.radius**2 - across * across) - along - np.float32(inner.radius)
    where = _inside(inner, cosine, sine, width, whole_frame(frame.size, frame.pixel_aspect))
    radius = np.maximum(width, 0) * _shares()
    radius += np.float32(inner.radius)
    profile = _sampled(frame, *_places(inner, radius, cosine, sine))
    profile -= np.float32(black)
    # From each sample on, the brightest.
    beyond = np.asarray(cv2.dilate(profile, _all_beyond(), anchor=(0, 0)))
    profile *= 2
    # The level must not pass for its own noise.
    dips = ((profile < beyond) & (beyond > _PLAIN_LEVEL)).any(axis=0)
    return float(np.count_nonzero(dips & where)) / max(int(np.count_nonzero(where)), 1)


@lru_cache(maxsize=1)
def _shares() -> Array:
    """Where the samples between two circles lie, of the way from the one to the other: (_BETWEEN, 1)."""
    return np.linspace(0, 1, _BETWEEN, dtype=np.float32)[:, None]


@lru_cache(maxsize=1)
def _all_beyond() -> NDArray[np.uint8]:
    return np.ones((_BETWEEN, 1), np.uint8)


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
    is_whole = lies_within(circle, half + _FRAME_EDGE, box)
    seen = _ALL if is_whole else inside_box(circle, _MARGIN * half, box)
    readings = _window_profiles(frame, circle, spacing).T @ _readings()
    at = readings[:, 1 : _EDGES - 1].argmax(axis=1)
    # The peak, to a fraction of a sample, by a parabola through it and its neighbours.
    peak = readings.take(at + _around())
    offset, bend = _PARABOLA @ peak
    offset /= np.maximum(bend, _LEAST_BEND, out=bend)
    np.minimum(np.maximum(offset, _NEXT[0], out=offset), _NEXT[1], out=offset)
    offset += _edge_places().take(at)
    offset *= np.float32(spacing)
    is_dark = readings[:, _EDGES] < dark.threshold + dark.noise
    if not is_whole:
        is_dark &= seen
    is_rim = is_dark & (peak[1] > dark.contrast)
    if not is_whole:
        is_rim &= _inside(circle, *directions(), offset + np.float32(_FRAME_EDGE), box)
    count = int(np.count_nonzero(is_rim))
    if count < _FEWEST:
        return None
    fitted = fit_offsets(all_bearings(), offset, is_rim, 0.25 * spacing, half / 3)
    if fitted is None:
        return None
    moved = Circle(circle.x + fitted.by.x, circle.y + fitted.by.y, circle.radius + fitted.by.radius)
    on_circle = int(np.count_nonzero(fitted.weight > 0.3))
    # An edge that has nothing to do with the circle lies anywhere in the window; on the circle it lies
    # within the width that the weights accept.
    gain = (half - _MEAN * spacing) / (_ACCEPTED * fitted.scale)
    return Rim(
        moved,
        fitted.scale,
        fitted.radius_sigma,
        fitted.center_sigma,
        DIRECTIONS if is_whole else int(np.count_nonzero(seen)),
        int(np.count_nonzero(is_dark)),
        count,
        on_circle,
        _sharpness((is_rim.astype(np.float32) @ readings).tolist()[_EDGES + 1 :]),
        on_circle * math.log(gain),
        RimPoints(angles(), is_rim, offset, fitted),
    )


def _sharpness(means: list[float]) -> float:
    """Return the fall over the middle half as a share of the whole: 1 for a step, a half for a slope."""
    first, second, third, last = means
    return (second - third) / (first - last) if first > last else 0.0
