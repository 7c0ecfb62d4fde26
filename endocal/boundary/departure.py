"""How far a rim that is no perfect circle leads its circle astray, where only a part of it is seen.

Real rims are slightly elliptic, and less and less so in finer waves: pixels that are not quite square, a stop
that is tilted. Over the whole circumference that cancels out. A short arc cannot tell it from another radius,
and its residuals hardly show it: a quarter of a circle that is 0.3 % elliptic looks 1 % wider or narrower.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .fit import Shift

Array = NDArray[np.float32]

# The waves around the rim that are reckoned with; below two they shift and widen the circle.
_WAVES = np.arange(2, 9)
# Amplitude of the second wave, of the radius, root mean square: 0.05 to 0.5 % in six endoscopes' recordings.
_USUAL = 1 / 300
# The amplitudes fall with this power of the wave's number.
_FALL = 3
# What the residuals of a whole circle count for against what is usual: four figures, the parts of its second
# and third wave, against one.
_WORTH = 4.0


class RimPoints(NamedTuple):
    """What a circle was fitted to: the rim's ``offset`` (n,) px at ``angles`` (n,), and the fit.

    ``used`` (n,) says at which of the angles there is a rim.
    """

    angles: Array
    used: NDArray[np.bool_]
    offset: Array
    fitted: Shift


def radius_departure(points: RimPoints, radius: float) -> float:
    """Return one standard deviation, px, of the radius for a rim that departs from a circle.

    How much it departs is taken from the residuals, as far as they hang together along the rim, and from
    what is usual where the arc is too short to show it.
    """
    fitted = points.fitted
    angles, offset, weight = (v[points.used] for v in (points.angles, points.offset, fitted.weight))
    waves = _waves_at(angles)
    base = waves[:3]
    weighted = base * weight
    # What each wave makes of the circle's width and place, (3, n of waves), and what it leaves as residuals.
    mistaken = np.linalg.solve(weighted @ base.T, weighted @ waves[3:].T)
    left = waves[3:] - mistaken.T @ base
    shift = fitted.by
    residual = offset - np.array((shift.radius, shift.x, shift.y)) @ base
    root = np.sqrt(weight)
    left, residual = left * root, residual * root
    # White noise has nothing in common from one radius to the next.
    common = float(residual[1:] @ residual[:-1])
    power = np.repeat((_WAVES[0] / _WAVES) ** (2.0 * _FALL), 2) / 2
    expected = float(power @ (left[:, 1:] * left[:, :-1]).sum(axis=1))
    departure2 = (_USUAL * radius) ** 2
    if expected > 0:
        whole = len(offset) * float(power.sum()) / 2
        worth = _WORTH * expected / whole
        departure2 = (departure2 + worth * max(common / expected, 0.0)) / (1 + worth)
    return math.sqrt(departure2 * float(power @ mistaken[0] ** 2))


def _waves_at(angles: Array) -> NDArray[np.float64]:
    """Return 1, then the cosine and sine of each wave from the first on: (1 + 2 waves, n)."""
    turns = np.multiply.outer(np.arange(1, _WAVES[-1] + 1), angles)
    return np.concatenate(
        [
            np.ones((1, len(angles))),
            np.stack([np.cos(turns), np.sin(turns)], axis=1).reshape(-1, len(angles)),
        ]
    )
