"""The least straightness that any division model reaches on given corners: what a calibration is held to."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from ..model import DivisionModel
from .corner_score import Corners, straightness

Floats = NDArray[np.float64]

# No corner's denominator may be smaller: at 0 all corners but one shrink to a point, and are straight.
LEAST_DENOMINATOR = 0.02
# Where the descent starts: lam times the squared radius of the farthest corner.
STARTS = np.linspace(-0.95, 0.3, 60)
# The simplex is set up anew until it gains no more than this, px, at most so often.
GAIN, MOST_RUNS = 1e-6, 6
STEPS = 2000


def least_straightness(
    corners: Corners, size: tuple[int, int], model: str = "division"
) -> tuple[float, DivisionModel]:
    """Return the least straightness of ``corners`` (rows, cols, 2) px, and the model that reaches it.

    It goes downhill from the best lambda with the centre in the middle of the frame of ``size`` (width,
    height), by ``model`` "division" or "division2". The lowest place of all would be at the pole: see
    LEAST_DENOMINATOR; on boards near the rim it leads there, too.
    """
    middle = (np.array(size, float) - 1) / 2
    reach = float(((corners - middle) ** 2).sum(axis=-1).max())
    unit = np.array([1 / reach, 20.0, 20.0, 1 / reach**2])

    def at(x: Floats) -> DivisionModel:
        lam, dx, dy, lam2 = unit[: len(x)] * x if len(x) > 3 else np.append(unit[:3] * x, 0.0)
        return DivisionModel(lam, (middle[0] + dx, middle[1] + dy), size, lam2=lam2)

    def cost(x: Floats) -> float:
        tried = at(x)
        q = ((corners - tried.center) ** 2).sum(axis=-1)
        least = float(tried.denominator(q).min())
        if least < LEAST_DENOMINATOR or q.max() >= tried.valid_radius**2:
            return 1e3 * (1 + max(0.0, LEAST_DENOMINATOR - least))
        return straightness(corners, tried)

    x = np.array([min(STARTS, key=lambda s: cost(np.array([s, 0.0, 0.0]))), 0.0, 0.0])
    x = _downhill(cost, x, np.array([0.05, 0.2, 0.2]))
    if model == "division2":
        x = _downhill(cost, np.append(x, 0.0), np.array([0.05, 0.2, 0.2, 0.02]))
    return cost(x), at(x)


def _downhill(cost: Callable[[Floats], float], x: Floats, steps: Floats) -> Floats:
    """Nelder and Mead's simplex, from a fresh one of these ``steps`` each time it has shrunk."""
    least = cost(x)
    for _ in range(MOST_RUNS):
        simplex = np.vstack([x, x + np.diag(steps)])
        options = {"initial_simplex": simplex, "xatol": 1e-6, "fatol": 1e-8, "maxiter": STEPS}
        found = minimize(cost, x, method="Nelder-Mead", options=options)
        x = found.x
        if found.fun > least - GAIN:
            break
        least = found.fun
    return np.asarray(x, np.float64)
