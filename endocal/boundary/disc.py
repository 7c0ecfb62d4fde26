"""A disc and a frame: how much of the one lies in the other."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

from .fit import Circle


class Box(NamedTuple):
    """A rectangle's outer edges, in square pixels: half a pixel beyond its outermost pixel centres."""

    left: float
    top: float
    right: float
    bottom: float


def whole_frame(size: tuple[int, int], pixel_aspect: float) -> Box:
    """Return the box of a frame of ``size`` (width, height) px."""
    half = 0.5 * pixel_aspect
    return Box(-half, -0.5, size[0] * pixel_aspect - half, size[1] - 0.5)


def visible_fraction(circle: Circle, box: Box) -> float:
    """Return the fraction of the circle's circumference inside the box, 0 to 1."""
    if lies_within(circle, 0.0, box):
        return 1.0
    r = circle.radius
    apart = _cutting_apart(circle, box)
    if apart is not None:
        return 1.0 - sum(math.acos(d / r) for d in apart) / math.pi
    cuts = [0.0, 2 * math.pi]
    for edge, at, vertical in (
        (box.left, circle.x, True),
        (box.right, circle.x, True),
        (box.top, circle.y, False),
        (box.bottom, circle.y, False),
    ):
        ratio = (edge - at) / r
        if -1 < ratio < 1:
            angle = math.acos(ratio) if vertical else math.asin(ratio)
            cuts += [
                angle % (2 * math.pi),
                (-angle if vertical else math.pi - angle) % (2 * math.pi),
            ]
    cuts.sort()
    inside = 0.0
    for a, b in pairwise(cuts):
        middle = (a + b) / 2
        x, y = circle.x + r * math.cos(middle), circle.y + r * math.sin(middle)
        if box.left <= x <= box.right and box.top <= y <= box.bottom:
            inside += b - a
    return inside / (2 * math.pi)


def lies_within(circle: Circle, margin: float, box: Box) -> bool:
    """Say whether the circle, widened by ``margin``, lies in the box as a whole."""
    x, y, r = circle.x, circle.y, circle.radius + margin
    return box.left <= x - r and x + r <= box.right and box.top <= y - r and y + r <= box.bottom


def disc_area(circle: Circle, box: Box) -> float:
    """Return the area of the disc inside the box."""
    r = circle.radius
    if lies_within(circle, 0.0, box):
        return math.pi * r * r
    apart = _cutting_apart(circle, box)
    if apart is not None:
        cut = sum(r * r * math.acos(d / r) - d * math.sqrt(r * r - d * d) for d in apart)
        return math.pi * r * r - cut
    left, right = box.left - circle.x, box.right - circle.x
    top, bottom = box.top - circle.y, box.bottom - circle.y
    return (
        _quadrant(right, bottom, r)
        - _quadrant(left, bottom, r)
        - _quadrant(right, top, r)
        + _quadrant(left, top, r)
    )


def _cutting_apart(circle: Circle, box: Box) -> list[float] | None:
    """Return how far from the centre those sides of the box are that cut the circle.

    None where what two of them cut off may overlap: beyond a corner inside the circle, or with the centre
    outside the box.
    """
    left, right = circle.x - box.left, box.right - circle.x
    top, bottom = circle.y - box.top, box.bottom - circle.y
    across, down = min(left, right), min(top, bottom)
    r = circle.radius
    if across < 0 or down < 0 or across * across + down * down < r * r:
        return None
    return [d for d in (left, right, top, bottom) if d < r]


def _quadrant(x: float, y: float, r: float) -> float:
    """Return the signed area of the disc about the origin within the rectangle from the origin to (x, y)."""
    sign = math.copysign(1, x) * math.copysign(1, y)
    x, y = min(abs(x), r), min(abs(y), r)
    if x * x + y * y <= r * r:
        return sign * x * y
    # Below the height y up to where the circle falls under it, then under the circle up to x.
    knee = math.sqrt(r * r - y * y)
    return sign * (knee * y + _under_circle(x, r) - _under_circle(knee, r))


def _under_circle(x: float, r: float) -> float:
    """Return the integral of sqrt(r^2 - t^2) from 0 to x."""
    return (x * math.sqrt(max(r * r - x * x, 0.0)) + r * r * math.asin(min(x / r, 1.0))) / 2
