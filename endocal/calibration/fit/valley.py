"""How lambda goes with a centre that is hardly told.

The images of parallel lines meet in two points, and any centre between these will do: with it goes
lambda' = lambda / (1 + lambda d^2), d px from the middle between the two. So where nothing but parallel lines
is seen, the models that make them straight lie in a curved valley. Of a fit that ends at its vertex the
slopes show none of that.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..straightness import Floats
from .measured import Refined, fit_again
from .plumb_line import Prior

# The centre is open where one standard deviation of it is this share of the one believed beforehand.
OPEN = 0.1


def with_valley(
    refined: Refined, covariance: Floats, reach: float, prior: Prior, content: float
) -> Floats:
    """Add to a fit's ``covariance`` (k, k) what lambda, and lam2, depart by from a straight valley.

    That is seen at models fitted with the centre held one standard deviation to both sides: of a parabola
    over a normal distribution the square of the curved part is 3/4 of their second difference's, squared.
    """
    if prior.fixed or refined.corners is not None:
        return covariance
    values, ways = np.linalg.eigh(covariance[1:3, 1:3])
    off = np.sqrt(max(values[-1], 0.0)) * ways[:, -1]
    if np.linalg.norm(off) < OPEN * np.hypot(*prior.spread):
        return covariance
    before, here, after = (_held(refined, step * off, reach, content) for step in (-1.0, 0.0, 1.0))
    curved = before - 2 * here + after
    curved[1:3] = 0.0
    return np.asarray(covariance + 0.75 * np.outer(curved, curved))


def _held(refined: Refined, off: Floats, reach: float, content: float) -> Floats:
    """The parameters (k,) of the model with its centre held ``off`` px, (2,), from where it was found."""
    start = refined.fit.params.copy()
    start[1:3] += off
    held = Prior((float(start[1]), float(start[2])), (0.0, 0.0))
    found = fit_again(replace(refined, corners=None), start, reach, held, content).fit.params
    return np.asarray(found, np.float64)
