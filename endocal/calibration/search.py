"""Algorithm 1 of Lee et al. 2013: a grid over (lambda, cx, cy), narrowed round by round."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .straightness import Floats

# (lams, xs, ys) -> costs of every combination, (len(lams), len(xs), len(ys)).
Measure = Callable[[Floats, Floats, Floats], Floats]


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
    measure: Measure, region: Region, samples: int, epsilon: float, max_rounds: int
) -> Found:
    """Minimise a measure over a region by rounds of ``samples`` per axis.

    The best sample's two neighbours on each axis bound the next round. It ends when they leave lambda a
    range below ``epsilon`` px^-2, or after ``max_rounds``. An axis whose range is a single value has one
    sample.
    """
    ranges = [region.lam, region.x, region.y]
    limits = list(ranges)
    best = Found(np.array([np.mean(r) for r in ranges]), np.inf, 0)
    for round_number in range(1, max_rounds + 1):
        axes = [np.linspace(*r, samples) if r[1] > r[0] else np.array([r[0]]) for r in ranges]
        costs = measure(*axes)
        at = np.unravel_index(int(np.argmin(costs)), costs.shape)
        params = np.array([axis[i] for axis, i in zip(axes, at, strict=True)])
        if costs[at] < best.cost:
            best = Found(params, float(costs[at]), round_number)
        steps = [axis[1] - axis[0] if len(axis) > 1 else 0.0 for axis in axes]
        ranges = [
            (max(limit[0], p - step), min(limit[1], p + step))
            for p, step, limit in zip(params, steps, limits, strict=True)
        ]
        if ranges[0][1] - ranges[0][0] < epsilon:
            break
    return Found(best.params, best.cost, round_number)
