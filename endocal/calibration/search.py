"""Algorithm 1 of Lee et al. 2013: a grid over (lambda, cx, cy), narrowed round by round."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from .straightness import Chosen, Floats

Range = tuple[float, float]

# Where it is searched again: to both sides of what was found, as a share of lambda and of half the region.
AROUND_LAMBDA, AROUND_CENTER = 0.12, 0.5
# A round of which a scout leaves this share to be measured is the last that it goes ahead in: the models of
# the next one are nearer to each other, and it would leave all.
STILL_MANY = 0.3


class Measure(Protocol):
    """The cost of models."""

    def __call__(
        self, lams: Floats, xs: Floats, ys: Floats, chosen: Chosen | None = None, /
    ) -> Floats:
        """Return the costs of every combination, (len(lams), len(xs), len(ys)).

        ``lams`` px^-2; ``xs`` and ``ys`` the centre's coordinates, px. Where ``chosen`` ones are given, of
        that shape, the others cost infinity.
        """
        ...


@dataclass(frozen=True)
class Scout:
    """A quicker ``measure`` that goes ahead: what it finds worse than its least by ``margin`` is left out."""

    measure: Measure
    margin: float

    def chosen(self, lams: Floats, xs: Floats, ys: Floats) -> Chosen:
        """Return which of every combination, (len(lams), len(xs), len(ys)), may have the least cost."""
        costs = self.measure(lams, xs, ys)
        return np.asarray(costs <= costs.min() + self.margin)


@dataclass(frozen=True)
class Found:
    """The combination of least cost: (lam px^-2, cx px, cy px), its cost, and how many rounds it took."""

    params: Floats
    cost: float
    rounds: int


@dataclass(frozen=True)
class Region:
    """The ranges that are searched, each (low, high): lambda in px^-2, the centre's x and y in px."""

    lam: tuple[float, float]
    x: tuple[float, float]
    y: tuple[float, float]


def search(
    measure: Measure,
    region: Region,
    samples: int,
    epsilon: float,
    max_rounds: int,
    again: int = 0,
    scout: Scout | None = None,
) -> Found:
    """Minimise a measure over a region by rounds of ``samples`` per axis.

    The best sample's two neighbours on each axis bound the next round. It ends when they leave lambda a
    range below ``epsilon`` px^-2, or after ``max_rounds``. An axis whose range is a single value has one
    sample.

    The valley of an entropy may be narrower than the first round's steps, and run askew to the axes: then it
    is left after that round, for good. So up to ``again`` times the search is done again around what it
    found, AROUND_LAMBDA to both sides and half of the centre's region, while that finds something better.

    Where a ``scout`` goes ahead, only what it leaves of a round is measured.
    """
    limits = (region.lam, region.x, region.y)
    best = _narrowed(measure, limits, limits, samples, epsilon, max_rounds, scout)
    shares = (
        AROUND_LAMBDA * abs(best.params[0]),
        *(AROUND_CENTER * (b - a) / 2 for a, b in limits[1:]),
    )
    for _ in range(again):
        ranges = _clipped(best.params, shares, limits)
        other = _narrowed(measure, ranges, limits, samples, epsilon, max_rounds, scout)
        rounds = best.rounds + other.rounds
        if other.cost >= best.cost:
            return Found(best.params, best.cost, rounds)
        best = Found(other.params, other.cost, rounds)
    return best


def _narrowed(
    measure: Measure,
    ranges: Sequence[Range],
    limits: Sequence[Range],
    samples: int,
    epsilon: float,
    max_rounds: int,
    scout: Scout | None,
) -> Found:
    """Algorithm 1, which starts with ``ranges`` and never leaves ``limits``."""
    best = Found(np.array([np.mean(r) for r in ranges]), np.inf, 0)
    for round_number in range(1, max_rounds + 1):
        lams, xs, ys = axes = [
            np.linspace(*r, samples) if r[1] > r[0] else np.array([r[0]]) for r in ranges
        ]
        if scout is None:
            costs = measure(lams, xs, ys)
        else:
            chosen = scout.chosen(lams, xs, ys)
            costs = measure(lams, xs, ys, chosen)
            if chosen.mean() > STILL_MANY:
                scout = None
        at = np.unravel_index(int(np.argmin(costs)), costs.shape)
        params = np.array([axis[i] for axis, i in zip(axes, at, strict=True)])
        if costs[at] < best.cost:
            best = Found(params, float(costs[at]), round_number)
        steps = [float(axis[1] - axis[0]) if len(axis) > 1 else 0.0 for axis in axes]
        ranges = _clipped(params, steps, limits)
        if ranges[0][1] - ranges[0][0] < epsilon:
            break
    return Found(best.params, best.cost, round_number)


def _clipped(params: Floats, halves: Sequence[float], limits: Sequence[Range]) -> list[Range]:
    """The ranges so far to both sides of ``params``, within limits."""
    return [
        (max(limit[0], float(p) - half), min(limit[1], float(p) + half))
        for p, half, limit in zip(params, halves, limits, strict=True)
    ]
