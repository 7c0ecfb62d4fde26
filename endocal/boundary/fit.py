"""Circles through points: a consensus over triples, and a robust geometric fit along radii."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float32]

_HYPOTHESES = 128
# Points that every hypothesis is tried on; more would cost time and hardly change the winner.
_JURY = 128
# Tukey's biweight: residuals beyond this many robust standard deviations count for nothing.
_TUKEY = 4.685
_MAD_TO_SIGMA = 1.4826
_FIT_ROUNDS, _SETTLED = 12, 0.02


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


def _low_discrepancy(rows: int) -> Array:
    """Triples in [0, 1) that fill the cube evenly: a fixed draw, so that the same points give one answer."""
    # Powers of 1/1.2207..., the three-dimensional golden ratio.
    steps = 1.2207440846057596 ** -np.arange(1.0, 4.0)
    return (np.arange(1, rows + 1)[:, None] * steps % 1).astype(np.float32)


_TRIPLES = _low_discrepancy(_HYPOTHESES)


def consensus_circle(
    x: Array, y: Array, radii: tuple[float, float], tolerance: float
) -> Circle | None:
    """Find the circle that most points lie on, within ``tolerance``, and fit it to those points.

    ``x`` and ``y`` are (n,) float32; ``radii`` bounds the radius. RANSAC (Fischler and Bolles 1981) with a
    fixed draw of triples. None when no triple gives a circle within the bounds.
    """
    n = len(x)
    if n < 6:
        return None
    picks = (_TRIPLES * n).astype(np.intp)
    px, py = x[picks], y[picks]
    ax, ay = px[:, 1] - px[:, 0], py[:, 1] - py[:, 0]
    bx, by = px[:, 2] - px[:, 0], py[:, 2] - py[:, 0]
    twice_area = 2 * (ax * by - ay * bx)
    a2, b2 = ax * ax + ay * ay, bx * bx + by * by
    with np.errstate(divide="ignore", invalid="ignore"):
        ux, uy = (by * a2 - ay * b2) / twice_area, (ax * b2 - bx * a2) / twice_area
    radius = np.sqrt(ux * ux + uy * uy)
    kept = np.flatnonzero((radius > radii[0]) & (radius < radii[1]))
    if not len(kept):
        return None
    cx, cy, radius = (ux + px[:, 0])[kept], (uy + py[:, 0])[kept], radius[kept]
    stride = -(-n // _JURY)
    distance = np.hypot(cx[:, None] - x[::stride], cy[:, None] - y[::stride])
    distance -= radius[:, None]
    np.abs(distance, out=distance)
    best = int(np.count_nonzero(distance < tolerance, axis=1).argmax())
    circle = Circle(float(cx[best]), float(cy[best]), float(radius[best]))
    for _ in range(2):
        near = np.abs(np.hypot(x - circle.x, y - circle.y) - circle.radius) < tolerance
        fitted = _algebraic_circle(x[near], y[near], circle)
        if fitted is None or not radii[0] < fitted.radius < radii[1]:
            break
        circle = fitted
    return circle


def _algebraic_circle(x: Array, y: Array, around: Circle) -> Circle | None:
    """Fit a circle by linear least squares (Kasa 1976), with ``around`` as the origin for conditioning."""
    if len(x) < 5:
        return None
    u, v = x - np.float32(around.x), y - np.float32(around.y)
    rows = np.stack([u, v, np.ones_like(u)])
    solution = _solve(rows @ rows.T, rows @ (u * u + v * v))
    if solution is None:
        return None
    cu, cv = solution[0] / 2, solution[1] / 2
    squared = solution[2] + cu * cu + cv * cv
    if squared <= 0:
        return None
    return Circle(float(around.x + cu), float(around.y + cv), float(np.sqrt(squared)))


def fit_offsets(
    cosine: Array,
    sine: Array,
    offset: Array,
    floor: float,
    reach: float,
    trust: Array | None = None,
) -> Shift | None:
    """Fit the shift (dx, dy, dr) of a circle to radial ``offset`` (n,) of its rim at n directions.

    To first order in the shift the offset is dx cos + dy sin + dr, which makes the geometric fit a linear
    one. Tukey's biweight keeps outliers out; its scale falls from ``reach`` to the residuals' own, not
    below ``floor`` (px), so that no part of the rim is an outlier before the shift is roughly known.
    ``trust`` (n,) weighs the directions besides.
    None where the directions do not fix a circle.
    """
    if len(offset) < 5:
        return None
    rows = np.stack([cosine, sine, np.ones_like(cosine)])
    middle = len(offset) // 2
    shift = np.zeros(3)
    scale, limit = math.inf, reach
    weight = np.ones_like(offset)
    trusted = rows if trust is None else rows * (trust / trust.max())
    for _ in range(_FIT_ROUNDS):
        weighted = trusted * weight
        solution = _solve(weighted @ rows.T, weighted @ offset)
        if solution is None:
            return None
        moved = float(np.abs(solution - shift).max())
        shift = solution
        absolute = np.abs(offset - shift.astype(np.float32) @ rows)
        scale = max(_MAD_TO_SIGMA * float(np.partition(absolute, middle)[middle]), floor)
        if moved < _SETTLED and limit <= scale:
            break
        limit = max(limit / 2, scale)
        weight = absolute * np.float32(1 / (_TUKEY * limit))
        weight = np.maximum(1 - weight * weight, 0)
        weight *= weight
    variances = _variances((trusted * weight) @ rows.T)
    if variances is None:
        return None
    sigmas = [scale * math.sqrt(max(v, 0.0)) for v in variances]
    return Shift(Circle(*shift.tolist()), weight, scale, sigmas[2], math.hypot(*sigmas[:2]))


def _variances(matrix: NDArray) -> list[float] | None:
    """Return the diagonal of a symmetric 3x3 matrix's inverse; None where it is singular."""
    columns = [_solve(matrix, axis) for axis in np.eye(3)]
    return (
        [float(c[i]) for i, c in enumerate(columns) if c is not None]
        if all(c is not None for c in columns)
        else None
    )


def _solve(matrix: NDArray, right: NDArray) -> NDArray[np.float64] | None:
    """Solve three normal equations; None where they are singular for all practical purposes."""
    (a, b, c), (_, d, e), (_, _, f) = matrix.tolist()
    p, q, r = right.tolist()
    # Cofactors of the symmetric matrix: cheaper by far than a call into LAPACK, and exact enough at n = 3.
    aa, bb, cc = d * f - e * e, c * e - b * f, b * e - c * d
    determinant = a * aa + b * bb + c * cc
    if not determinant > 1e-7 * a * d * f:
        return None
    dd, ee, ff = a * f - c * c, b * c - a * e, a * d - b * b
    return np.array(
        [
            (aa * p + bb * q + cc * r) / determinant,
            (bb * p + dd * q + ee * r) / determinant,
            (cc * p + ee * q + ff * r) / determinant,
        ]
    )
