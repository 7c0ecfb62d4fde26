"""A chessboard's corners to sub-pixel, where its measured lines cross."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..measure.profiles import Measured
from ..straightness import Floats
from .lattice import Crossings, places_of
from .lifted import Corners
from .pattern import crossings_of

# A line is followed from a corner to both sides for this share of the way to the next corner.
NEAR = 0.6
# Points that this must leave on each side of the corner.
FEWEST_BESIDE = 3
# Where the curves meet lies no farther than this, px, from where both lines change sides.
FARTHEST = 4.0
# Steps from a crossing known to a px or two to where the curves meet.
STEPS = 4


def corners_of(measured: Measured) -> Corners:
    """Return the corners of the board whose lines were measured; none where there is no board.

    ``measured`` is clear of crossings, where edges draw each other off. Near a corner each line is a
    parabola, moved to one side and to the other by what bright squares grow.
    """
    crossings = crossings_of(measured)
    places, known = places_of(crossings)
    found: dict[tuple[int, int], Floats | None] = {}
    for i in np.flatnonzero(known).tolist():
        place = (int(places[i, 0]), int(places[i, 1]))
        # What two pairs of lines claim is nobody's.
        found[place] = None if place in found else _meeting(measured, crossings, i)
    kept = {place: point for place, point in found.items() if point is not None}
    points = np.array(list(kept.values()), np.float64).reshape(-1, 2)
    return Corners(points, np.array(list(kept), np.intp).reshape(-1, 2))


def _meeting(measured: Measured, crossings: Crossings, i: int) -> Floats | None:
    """Where the two lines of crossing ``i`` meet, (2,) px; None where too little of them is seen there."""
    curves = []
    start = crossings.places[i]
    for line in crossings.lines[i]:
        on_line = (crossings.lines == line).any(axis=1)
        on_line[i] = False
        if not on_line.any():
            return None
        reach = NEAR * float(np.linalg.norm(crossings.places[on_line] - start, axis=1).min())
        own = slice(*np.searchsorted(measured.labels, [line, line + 1]))
        away = np.linalg.norm(measured.points[own] - start, axis=1)
        near = np.flatnonzero(away < reach) + own.start
        curve = _Curve.through(measured.points[near], measured.sides[near], start)
        if curve is None:
            return None
        curves.append(curve)
    at = start
    for _ in range(STEPS):
        off, slopes = zip(*(curve.off(at) for curve in curves), strict=True)
        at = at - np.linalg.solve(np.array(slopes), np.array(off))
    return at if np.linalg.norm(at - start) < FARTHEST else None


@dataclass(frozen=True)
class _Curve:
    """The parabola y = a + b x + c x^2 in axes (2, 2), unit rows, about an origin (2,) px."""

    origin: Floats
    axes: Floats
    a: float
    b: float
    c: float

    @classmethod
    def through(cls, points: Floats, sides: Floats, origin: Floats) -> _Curve | None:
        """Fit points (n, 2) of a line, bright on ``sides`` (n,); None with too few beside the origin."""
        if len(points) < 2 * FEWEST_BESIDE:
            return None
        axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2]
        x, y = ((points - origin) @ axes.T).T
        if min(np.count_nonzero(x < 0), np.count_nonzero(x > 0)) < FEWEST_BESIDE:
            return None
        columns = np.stack([np.ones_like(x), x, x * x, sides], axis=1)
        a, b, c, _ = np.linalg.lstsq(columns, y, rcond=None)[0]
        return cls(origin, axes, float(a), float(b), float(c))

    def off(self, at: Floats) -> tuple[float, Floats]:
        """Return how far ``at`` (2,) px lies beside the curve, and that distance's gradient (2,)."""
        x, y = self.axes @ (at - self.origin)
        slope = self.b + 2 * self.c * x
        return float(y - self.a - x * (self.b + self.c * x)), self.axes[1] - slope * self.axes[0]
