"""Circles through points: a consensus over triples, and a robust geometric fit along radii.

These run on every frame of a video, on a hundred numbers or so: what counts is how few calls they make.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float32]

# Triples that are tried at first, and those that follow where no circle has this share of the points.
_HYPOTHESES, _CLEAR = (40, 120), 0.6
# With this share of the points on it, a circle needs no further search.
_NEARLY_ALL = 0.85
# Points that every hypothesis is tried on; more would cost time and hardly change the winner.
_JURY = 96
# Tukey's biweight: residuals beyond this many robust standard deviations count for nothing.
_TUKEY = 4.685
_MAD_TO_SIGMA = 1.4826
_FIT_ROUNDS, _SETTLED = 12, 0.05
_ZERO, _ONE = np.float32(0), np.float32(1)


class Circle(NamedTuple):
    """A circle in square pixels."""

    x: float
    y: float
    radius: float


class Shift(NamedTuple):
    """How a circle has to move to meet its rim: ``by`` (dx, dy, dr), and how well the rim then agrees.

    ``weight`` (n,) is 0 to 1 per rim point, ``scale`` their robust standard deviation about the circle in
    px, ``radius_sigma`` and ``center_sigma`` the standard deviations that follow from it.
    """

    by: Circle
    weight: Array
    scale: float
    radius_sigma: float
    center_sigma: float


def _low_discrepancy(columns: int) -> Array:
    """Triples in [0, 1) that fill the cube evenly: a fixed draw, so that the same points give one answer."""
    # Powers of 1/1.2207..., the three-dimensional golden ratio.
    steps = 1.2207440846057596 ** -np.arange(1.0, 4.0)
    return (steps[:, None] * np.arange(1, columns + 1) % 1).astype(np.float32)


_FIRST_TRIPLES, _MORE_TRIPLES = np.split(
    _low_discrepancy(sum(_HYPOTHESES)), [_HYPOTHESES[0]], axis=1
)


def consensus_circle(places: Array, radii: tuple[float, float], tolerance: float) -> Circle | None:
    """Find the circle that most points lie on, within ``tolerance``, and fit it to those points.

    ``places`` are (2, n) float32, x and y; ``radii`` bounds the radius. Where nearly all points are on one
    circle, least squares finds it; else RANSAC does (Fischler and Bolles 1981), with a fixed draw of
    triples. None when no triple gives a circle within the bounds.
    """
    n = places.shape[1]
    if n < 6:
        return None
    # About the first point, so that squares stay small enough for single precision.
    points = np.empty((4, n), np.float32)
    origin = places[:, :1]
    x, y = np.subtract(places, origin, out=points[:2])
    points[2] = 1
    np.multiply(x, x, out=points[3])
    points[3] += y * y
    found = _common_circle(points, radii, tolerance) or _most_voted(points, radii, tolerance)
    if found is None:
        return None
    return Circle(found.x + float(origin[0, 0]), found.y + float(origin[1, 0]), found.radius)


def _common_circle(points: Array, radii: tuple[float, float], tolerance: float) -> Circle | None:
    """Fit a circle to all points (4, n), and to those near it; None unless nearly all are."""
    chosen = points
    for _ in range(2):
        circle = _algebraic_circle(chosen)
        if circle is None or not radii[0] <= circle.radius <= radii[1]:
            return None
        near = _near(points, circle, tolerance)
        if np.count_nonzero(near) > _NEARLY_ALL * points.shape[1]:
            return _algebraic_circle(points[:, near])
        chosen = points[:, near]
    return None


def _most_voted(points: Array, radii: tuple[float, float], tolerance: float) -> Circle | None:
    """Fit a circle to the points (4, n) near that circle through three of them which has most near it."""
    n = points.shape[1]
    jury = points[:, :: -(-n // _JURY)]
    best, votes = None, 0.0
    for triples in (_FIRST_TRIPLES, _MORE_TRIPLES):
        circles = _circles_through(points[:2, (triples * n).astype(np.intp)])
        agree = (
            np.abs(_membership(circles, tolerance) @ jury) < (2 * tolerance * circles[2])[:, None]
        )
        counts = agree.astype(np.float32) @ np.ones(jury.shape[1], np.float32)
        counts[(circles[2] < radii[0]) | (circles[2] > radii[1])] = 0
        winner = int(counts.argmax())
        if counts[winner] > votes:
            votes, best = float(counts[winner]), Circle(*circles[:, winner].tolist())
        # Where most points agree, more triples would only find the same circle again.
        if votes > _CLEAR * jury.shape[1]:
            break
    if best is None:
        return None
    found = _algebraic_circle(points[:, _near(points, best, tolerance)])
    return found if found is not None and radii[0] <= found.radius <= radii[1] else best


def _near(points: Array, circle: Circle, tolerance: float) -> NDArray[np.bool_]:
    """Say which points (4, n) are within ``tolerance`` of the circle."""
    x, y, r = circle
    row = np.array([-2 * x, -2 * y, x * x + y * y - r * r - tolerance * tolerance, 1], np.float32)
    return np.abs(row @ points) < 2 * tolerance * r


def _membership(circles: Array, tolerance: float) -> Array:
    """Return rows (m, 4) whose product with (x, y, 1, x^2 + y^2) tells a point's distance from each circle.

    |product| < 2 tolerance radius means |distance - radius| < tolerance, with squares in place of roots.
    """
    cx, cy, radius = circles
    rows = np.empty((len(cx), 4), np.float32)
    rows[:, 0] = -2 * cx
    rows[:, 1] = -2 * cy
    rows[:, 2] = cx * cx + cy * cy - radius * radius - tolerance * tolerance
    rows[:, 3] = 1
    return rows


def _circles_through(triples: Array) -> Array:
    """Return the circles (x, y, radius), (3, m), through triples of points, (2, 3, m); 0 for a line."""
    (x0, x1, x2), (y0, y1, y2) = triples
    ax, ay, bx, by = x1 - x0, y1 - y0, x2 - x0, y2 - y0
    a2, b2 = ax * ax + ay * ay, bx * bx + by * by
    twice_area = 2 * (ax * by - ay * bx)
    on_a_line = np.abs(twice_area) < 1
    twice_area[on_a_line] = 1
    ux, uy = (by * a2 - ay * b2) / twice_area, (ax * b2 - bx * a2) / twice_area
    radius = np.sqrt(ux * ux + uy * uy)
    radius[on_a_line] = 0
    circles = np.empty((3, len(x0)), np.float32)
    circles[0], circles[1], circles[2] = ux + x0, uy + y0, radius
    return circles


def _algebraic_circle(points: Array) -> Circle | None:
    """Fit a circle by linear least squares (Kasa 1976) to points (4, n): x, y, 1 and x^2 + y^2."""
    (xx, xy, x1, right_x), (_, yy, y1, right_y), (_, _, one, right_1), _ = (
        points @ points.T
    ).tolist()
    inverse = _inverse((xx, xy, x1, yy, y1, one))
    if inverse is None:
        return None
    a, b, c = _times(inverse, (right_x, right_y, right_1))
    x, y = a / 2, b / 2
    squared = c + x * x + y * y
    return Circle(x, y, math.sqrt(squared)) if squared > 0 else None


def bearings(angles: Array) -> Array:
    """Return what ``fit_offsets`` needs of the directions at these ``angles`` (n,): float32 (9, n).

    The weighted sums of its rows make the normal equations: cos^2, cos sin, sin^2; cosine and sine times the
    offset; cosine, sine, 1; and the offset. Where the offset comes in there is 0 as yet.
    """
    cosine, sine = np.cos(angles), np.sin(angles)
    none, one = np.zeros_like(cosine), np.ones_like(cosine)
    products = (cosine * cosine, cosine * sine, sine * sine)
    rows = (*products, none, none, cosine, sine, one, none)
    return np.stack(rows).astype(np.float32)


def fit_offsets(
    along: Array,
    offset: Array,
    used: NDArray[np.bool_],
    floor: float,
    reach: float,
    trust: Array | None = None,
) -> Shift | None:
    """Fit the shift (dx, dy, dr) of a circle to radial ``offset`` (n,) of its rim at n directions.

    ``along`` (9, n) are the directions' ``bearings``; only those that are ``used`` (n,) count.
    To first order in the shift the offset is dx cos + dy sin + dr, which makes the geometric fit a linear
    one. Tukey's biweight keeps outliers out; its scale falls from ``reach`` to the residuals' own, not
    below ``floor`` (px), so that no part of the rim is an outlier before the shift is roughly known.
    ``trust`` (n,) weighs the directions besides. None where the directions do not fix a circle.
    """
    count = int(np.count_nonzero(used))
    if count < 5:
        return None
    rows = along.copy()
    np.multiply(rows[5:7], offset, out=rows[3:5])
    rows[8] = offset
    linear = rows[5:]
    trusted = used.astype(np.float32)
    if trust is not None:
        trusted *= trust / trust.max()
    weight, weighted = trusted, trusted
    shift = (0.0, 0.0, 0.0)
    limit, middle = reach, count // 2
    inverse = None
    for _ in range(_FIT_ROUNDS):
        cc, cs, ss, co, so, c, s, one, o = (rows @ weighted).tolist()
        inverse = _inverse((cc, cs, c, ss, s, one))
        if inverse is None:
            return None
        last, shift = shift, _times(inverse, (co, so, o))
        residual2 = np.array((*shift, -1), np.float32) @ linear
        residual2 *= residual2
        ordered = residual2[used]
        ordered.sort()
        scale = max(_MAD_TO_SIGMA * math.sqrt(ordered[middle]), floor)
        if limit <= scale:
            moved = max(abs(shift[0] - last[0]), abs(shift[1] - last[1]), abs(shift[2] - last[2]))
            if moved < _SETTLED:
                break
        # Where half of the rim is as near as can be told, the shift is known.
        limit = scale if scale == floor else max(limit / 6, scale)
        residual2 *= -1 / (_TUKEY * limit) ** 2
        residual2 += _ONE
        weight = np.maximum(residual2, _ZERO, out=residual2)
        weight *= weight
        weighted = weight * trusted
    assert inverse is not None
    radius_sigma = scale * math.sqrt(max(inverse[5], 0.0))
    center_sigma = scale * math.sqrt(max(inverse[0] + inverse[3], 0.0))
    weight = weighted if trust is None else weight * used
    return Shift(Circle(*shift), weight, scale, radius_sigma, center_sigma)


# The upper triangle of a symmetric 3x3 matrix, row by row.
Triangle = tuple[float, float, float, float, float, float]


def _inverse(matrix: Triangle) -> Triangle | None:
    """Invert a symmetric 3x3 matrix; None where it is singular for all practical purposes."""
    a, b, c, d, e, f = matrix
    # Cofactors: cheaper by far than a call into LAPACK, and exact enough at n = 3.
    aa, bb, cc = d * f - e * e, c * e - b * f, b * e - c * d
    determinant = a * aa + b * bb + c * cc
    if not determinant > 1e-7 * a * d * f:
        return None
    dd, ee, ff = a * f - c * c, b * c - a * e, a * d - b * b
    return (
        aa / determinant,
        bb / determinant,
        cc / determinant,
        dd / determinant,
        ee / determinant,
        ff / determinant,
    )


def _times(matrix: Triangle, right: Sequence[float]) -> tuple[float, float, float]:
    a, b, c, d, e, f = matrix
    p, q, r = right
    return a * p + b * q + c * r, b * p + d * q + e * r, c * p + e * q + f * r
