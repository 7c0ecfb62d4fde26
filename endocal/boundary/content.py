"""How far the visible content reaches: what a lens model has to hold for."""

from __future__ import annotations

import math
from collections.abc import Iterator

from ..errors import InputError
from .circle import Boundary


def content_radius(
    center: tuple[float, float],
    size: tuple[int, int],
    boundary: Boundary | None = None,
    pixel_aspect: float = 1.0,
) -> float:
    """Return the distance from ``center`` to the farthest visible content, in px of the frame's height.

    The content is the part of the boundary circle that lies in the frame, or the whole frame without
    one; the frame reaches from the first pixel's centre to the last one's. ``center`` is (x, y) in px,
    ``size`` (width, height) in px. Raises InputError where the circle misses the frame.
    """
    cx, cy = center[0] * pixel_aspect, center[1]
    right, bottom = (size[0] - 1) * pixel_aspect, float(size[1] - 1)
    corners = [(0.0, 0.0), (right, 0.0), (0.0, bottom), (right, bottom)]
    if boundary is None:
        return max(math.hypot(x - cx, y - cy) for x, y in corners)
    bx, by = boundary.center[0] * pixel_aspect, boundary.center[1]
    radius = boundary.diameter / 2
    # The farthest point of a convex region is one of its extreme points: a corner of the frame inside the
    # circle, a crossing of the two, or the point of the circle opposite the centre.
    away = math.hypot(bx - cx, by - cy)
    ux, uy = ((bx - cx) / away, (by - cy) / away) if away > 0 else (1.0, 0.0)
    candidates = [(bx + radius * ux, by + radius * uy), *_axis_points(bx, by, radius)]
    inside = [(x, y) for x, y in candidates if 0 <= x <= right and 0 <= y <= bottom]
    inside += [(x, y) for x, y in corners if math.hypot(x - bx, y - by) <= radius]
    inside += _crossings(bx, by, radius, right, bottom)
    if not inside:
        raise InputError(f"the boundary circle lies outside the {size[0]}x{size[1]} frame")
    return max(math.hypot(x - cx, y - cy) for x, y in inside)


def _axis_points(bx: float, by: float, radius: float) -> list[tuple[float, float]]:
    return [(bx + radius, by), (bx - radius, by), (bx, by + radius), (bx, by - radius)]


def _crossings(
    bx: float, by: float, radius: float, right: float, bottom: float
) -> Iterator[tuple[float, float]]:
    """Yield where the circle crosses the frame's four sides."""
    for x in (0.0, right):
        if abs(x - bx) <= radius:
            half = math.sqrt(radius**2 - (x - bx) ** 2)
            yield from ((x, y) for y in (by - half, by + half) if 0 <= y <= bottom)
    for y in (0.0, bottom):
        if abs(y - by) <= radius:
            half = math.sqrt(radius**2 - (y - by) ** 2)
            yield from ((x, y) for x in (bx - half, bx + half) if 0 <= x <= right)
