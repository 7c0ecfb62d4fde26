"""From the cost of one model to a measure over a grid of models."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..search import Measure
from ..straightness import Floats

__all__ = ["Measure", "over_grid"]


def over_grid(cost: Callable[[float, float, float], float]) -> Measure:
    """Turn the cost of one model, by (lam px^-2, cx px, cy px), into a measure over a grid of them."""

    def measure(lams: Floats, xs: Floats, ys: Floats) -> Floats:
        out = np.empty((len(lams), len(xs), len(ys)))
        for at in np.ndindex(out.shape):
            out[at] = cost(float(lams[at[0]]), float(xs[at[1]]), float(ys[at[2]]))
        return out

    return measure
