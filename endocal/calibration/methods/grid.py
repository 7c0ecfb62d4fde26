"""From the cost of one model to a measure over a grid of them, and to a method: Algorithm 1's search."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..fit.view import View
from ..image.directions import directions_along
from ..image.edges import EdgePoints, edge_directions
from ..image.sampling import from_reduced, reduced, to_reduced
from ..search import Found, Measure, Scout, search
from ..straightness import Chosen, Floats
from .task import MOST_POINTS, Task

__all__ = ["Measure", "NamedMeasure", "Prepare", "over_grid", "voting_edges"]

# (points (n, 2) px, gradients (n, 2), the frame's size (width, height) px) -> the measure over them.
Prepare = Callable[[Floats, Floats, tuple[float, float]], Measure]

# An edge point votes where what is around it is so much of one direction (see edge_directions) within half
# the size that is looked at, and where the points along its edge, this share of it to both sides, tell that.
ONE_DIRECTION = 0.6
REACH = 0.7
# At least this share of all points votes; and so many more than are wanted are looked at.
FEWEST_VOTERS = 0.2
SPARE = 1.5
# Searches that follow the first, at most, around what was found (see search).
AGAIN = 3
# One edge point in so many is a scout's. An entropy is a mean over the votes, so that of fewer is off by
# one over the square root of their number, times this at most: of what was least over all points, a quarter
# of them gave 3.0 of that more than their own least at worst, in 156 searches on random boards and real ones.
SCOUTS = 4
SCOUTS_MARGIN = 4.0


@dataclass(frozen=True)
class NamedMeasure:
    """How a measure is made from edge points, and how many of them it takes at most, for what it costs.

    ``scouted`` ones are those of which fewer points tell, as SCOUTS_MARGIN has it, what need not be measured.
    """

    prepare: Prepare
    most_points: int = MOST_POINTS
    scouted: bool = False

    def over(self, task: Task) -> Measure:
        """Return the measure averaged over a task's views."""
        return self._averaged(self._voters(task), task)

    def solve(self, task: Task) -> Found:
        """Minimise it by Algorithm 1."""
        spec = task.spec
        again = 0 if spec.refine else AGAIN
        voters = self._voters(task)
        measure = self._averaged(voters, task)
        scout = None
        if self.scouted:
            few = [edges.take(slice(None, None, SCOUTS)) for edges in voters]
            scout = Scout(self._averaged(few, task), margin([len(edges) for edges in few]))
        return search(
            measure, task.region, spec.samples, spec.epsilon, spec.max_rounds, again, scout
        )

    def _voters(self, task: Task) -> list[EdgePoints]:
        most = min(self.most_points, task.most_points)
        return [voting_edges(view, task.spec.sobel, most) for view in task.views]

    def _averaged(self, voters: Sequence[EdgePoints], task: Task) -> Measure:
        measures = [self.prepare(edges.points, edges.gradients, task.size) for edges in voters]

        def cost(lams: Floats, xs: Floats, ys: Floats, chosen: Chosen | None = None) -> Floats:
            return np.mean([measure(lams, xs, ys, chosen) for measure in measures], axis=0)

        return cost


def margin(votes: Sequence[int]) -> float:
    """Return the margin of scouts with so many votes each, of whose entropies the mean is taken."""
    return SCOUTS_MARGIN * float(np.sqrt((1 / np.asarray(votes)).sum())) / len(votes)


def over_grid(cost: Callable[[float, float, float], float]) -> Measure:
    """Turn the cost of one model, by (lam px^-2, cx px, cy px), into a measure over a grid of them."""

    def measure(lams: Floats, xs: Floats, ys: Floats, chosen: Chosen | None = None) -> Floats:
        out = np.full((len(lams), len(xs), len(ys)), np.inf)
        for i, j, k in np.ndindex(out.shape) if chosen is None else np.argwhere(chosen):
            out[i, j, k] = cost(float(lams[i]), float(xs[j]), float(ys[k]))
        return out

    return measure


def voting_edges(view: View, sobel: int, most: int) -> EdgePoints:
    """Return at most ``most`` edge points of a view, drawn evenly, with the normals of their edges.

    Normals are those of the lines through the points along the edges (see ``directions_along``), and points
    are moved onto these. ``sobel`` px, of the picture on which the edges were sought, is the size of what is
    looked at. Points that see more than one direction, next to a crossing of lines above all, are left out:
    they would vote for lines that are not there.
    """
    edges = EdgePoints(to_reduced(view.edges.points, view.step), view.edges.gradients)
    grey = reduced(view.grey, view.step)
    normals, one_direction = edge_directions(grey, edges.points, sobel // 2 | 1)
    normals *= np.where((normals * edges.gradients).sum(axis=1) < 0, -1, 1)[:, None]
    clear = one_direction >= min(ONE_DIRECTION, np.quantile(one_direction, 1 - FEWEST_VOTERS))
    edges = EdgePoints(edges.points, normals).take(clear)
    drawn = np.random.default_rng(0).permutation(len(edges))[: int(SPARE * most)]
    voters, told = directions_along(edges, drawn, REACH * sobel)
    # Where lines are too short for that, others vote, too, by the gradients around them.
    fewest = min(most, int(FEWEST_VOTERS * len(view.edges)), len(drawn))
    first = np.argsort(~told, kind="stable")
    voters = voters.take(first[: min(most, max(fewest, np.count_nonzero(told)))])
    return EdgePoints(from_reduced(voters.points, view.step), voters.gradients)
