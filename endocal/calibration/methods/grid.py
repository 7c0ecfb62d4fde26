"""From the cost of one model to a measure over a grid of them, and to a method: Algorithm 1's search."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..edges import EdgePoints, sobel_gradients
from ..measured_fit import View
from ..search import Found, Measure, search
from ..straightness import Floats
from .task import MOST_POINTS, Task

__all__ = ["Measure", "NamedMeasure", "Prepare", "over_grid", "voting_edges"]

# (points (n, 2) px, gradients (n, 2), the frame's size (width, height) px) -> the measure over them.
Prepare = Callable[[Floats, Floats, tuple[float, float]], Measure]


@dataclass(frozen=True)
class NamedMeasure:
    """How a measure is made from edge points, and how many of them it takes at most, for what it costs."""

    prepare: Prepare
    most_points: int = MOST_POINTS

    def over(self, task: Task) -> Measure:
        """Return the measure averaged over a task's views."""
        most = min(self.most_points, task.most_points)
        measures = []
        for view in task.views:
            edges = voting_edges(view, task.spec.sobel, most)
            measures.append(self.prepare(edges.points, edges.gradients, task.size))

        def cost(lams: Floats, xs: Floats, ys: Floats) -> Floats:
            return np.mean([measure(lams, xs, ys) for measure in measures], axis=0)

        return cost

    def solve(self, task: Task) -> Found:
        """Minimise it by Algorithm 1."""
        spec = task.spec
        return search(self.over(task), task.region, spec.samples, spec.epsilon, spec.max_rounds)


def over_grid(cost: Callable[[float, float, float], float]) -> Measure:
    """Turn the cost of one model, by (lam px^-2, cx px, cy px), into a measure over a grid of them."""

    def measure(lams: Floats, xs: Floats, ys: Floats) -> Floats:
        out = np.empty((len(lams), len(xs), len(ys)))
        for at in np.ndindex(out.shape):
            out[at] = cost(float(lams[at[0]]), float(xs[at[1]]), float(ys[at[2]]))
        return out

    return measure


def voting_edges(view: View, sobel: int, most: int) -> EdgePoints:
    """Return at most ``most`` edge points of a view, drawn evenly, with their Sobel gradients."""
    edges = view.edges
    gradients = sobel_gradients(view.grey, edges.points, sobel)
    if len(edges) > most:
        chosen = np.random.default_rng(0).permutation(len(edges))[:most]
        edges, gradients = edges.take(chosen), gradients[chosen]
    return EdgePoints(edges.points, gradients)
