"""From edge points to a model: starting points, grouping into lines, then the fit of what is measured.

All coordinates are in square pixels.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..board.pattern import merge_twins
from ..image.edges import EdgePoints
from ..straightness import Floats, Labels
from .following import followed
from .grouping import Grouping, LineSpec, group
from .measured import ENOUGH_POINTS, FEWEST_LINES, Refined, fit_measured
from .outer_lines import with_outer_lines
from .plumb_line import Prior, fit_model
from .view import View

# Where the fit is started besides the search's answer: lambda times the squared reach of the points.
STARTS = (-1.4, -0.9, -0.4, 0.0)
# Points that the starts are compared on; all of them serve from then on. As many are of no more views than so
# many: of more, each keeps enough for its lines.
SCOUTS, SCOUTED_VIEWS = 3000, 4
# How near to its line a point must be, px, in the rounds of a start, and in those of the one that won.
START_ROUNDS = (5.0, 3.5, 2.5)
START_JUDGED = 2.0
GROUP_ROUNDS = (2.0, 1.5)
# Of the points' reach: the shortest span of a line. Points a line needs at least.
SHORTEST_SPAN = 0.08
FEWEST_POINTS = 25
# Two starts that end this near to each other, as a share of the reach, ended in one place; and a model
# that moved by less than STABLE would group the points as before. At most so many groupings.
ALIKE, STABLE = 0.015, 0.003
MOST_PASSES = 3
# A grouping that loses more than this of the points measured on a board's lines before is no better one.
AS_MANY = 0.97
# Lines nearer to each other than this, px, are one.
TWINS = 1.0


def reach_of(views: Sequence[View], center: tuple[float, float]) -> float:
    """The distance in px within which nearly all edge points lie from ``center``."""
    return max(
        float(np.quantile(np.linalg.norm(v.edges.points - center, axis=1), 0.98)) for v in views
    )


def best_start(views: Sequence[View], found: Floats, reach: float, prior: Prior) -> Floats | None:
    """Improve the search's answer and other starts by grouping and fitting in turn; return the best.

    What is compared is the entropy of the lines' shares of the points, in distorted px: unlike that of a
    vote map, it does not fall when a model shrinks the picture. Two starts that end in one place with no
    better one before them settle it. None where no start finds a line.
    """
    total = sum(len(v.edges) for v in views)
    count = SCOUTS * max(1.0, len(views) / SCOUTED_VIEWS)
    share = min(1.0, count / max(total, 1))
    scouts = [replace(v, edges=_scouts(v.edges, share)) for v in views]
    spec = LineSpec(0.0, np.deg2rad(8), max(10, int(FEWEST_POINTS * share)), SHORTEST_SPAN * reach)
    # The farthest from the search's answer first: where those come back to it, it is right.
    others = sorted(STARTS, key=lambda s: -abs(s - found[0] * reach**2))
    starts = [found, *(np.array([s / reach**2, *prior.center]) for s in others)]
    ends: list[tuple[float, Floats]] = []
    for start in starts:
        end = _improved(scouts, start, reach, prior, spec)
        if end is None:
            continue
        ends.append(end)
        best = min(ends, key=lambda e: e[0])
        if sum(_same(best[1], other, reach, ALIKE) for _, other in ends) > 1:
            return best[1]
    return min(ends, key=lambda e: e[0])[1] if ends else None


def _improved(
    scouts: Sequence[View], params: Floats, reach: float, prior: Prior, spec: LineSpec
) -> tuple[float, Floats] | None:
    """Where a start leads, and the entropy there; None where it finds too few lines."""
    for distance in START_ROUNDS:
        groups = _group(scouts, params, replace(spec, distance=distance))
        points, labels = _on_lines(scouts, groups)
        if len(points) == 0 or labels.max() + 1 < FEWEST_LINES:
            break
        params = fit_model(points, labels, params, reach, prior, distance / 3, rounds=8).params
    groups = _group(scouts, params, replace(spec, distance=START_JUDGED))
    if sum(g.count for g in groups) < FEWEST_LINES:
        return None
    return float(np.mean([g.entropy() for g in groups])), params


def _same(a: Floats, b: Floats, reach: float, tolerance: float) -> bool:
    """Whether two models bend the farthest points, and put the centre, alike to a share of the reach."""
    bent = (a[0] - b[0]) * reach**2
    if len(a) > 3:
        bent += (a[3] - (b[3] if len(b) > 3 else 0.0)) * reach**4
    return bool(abs(bent) < tolerance and np.hypot(*(a[1:3] - b[1:3])) < tolerance * reach)


def refine(
    views: Sequence[View],
    start: Floats,
    reach: float,
    prior: Prior,
    second: bool = False,
    content: float = 0.0,
) -> list[Refined]:
    """Fit the model from ``start``; with ``second``, lam2 too, monotonic within ``content`` px.

    The points are grouped again under each better model, since a poor one breaks long lines into pieces.
    Returns the best, and after it what else was seen on the way; nothing where too few lines hold.
    """
    best = _refined_once(views, start, reach, prior, second, content)
    if best is None:
        return []
    looks = [best]
    while len(looks) < MOST_PASSES and not _same(best.fit.params, start, reach, STABLE):
        start = best.fit.params
        again = _refined_once(views, start, reach, prior, second, content)
        if again is None:
            break
        looks.append(again)
        if best.board and len(again.measured.points) < AS_MANY * len(best.measured.points):
            break
        best = again
    return [best, *(look for look in looks if look is not best)]


def _refined_once(
    views: Sequence[View],
    start: Floats,
    reach: float,
    prior: Prior,
    second: bool,
    content: float,
) -> Refined | None:
    params, sigma = start, 1.0
    spec = LineSpec(0.0, np.deg2rad(6), FEWEST_POINTS, SHORTEST_SPAN * reach)
    for distance in GROUP_ROUNDS:
        groups = _group(views, params, replace(spec, distance=distance))
        points, labels = _on_lines(views, groups)
        if len(points) == 0 or labels.max() + 1 < FEWEST_LINES:
            return None
        few = slice(None, None, max(1, len(points) // ENOUGH_POINTS))
        fit = fit_model(points[few], labels[few], params, reach, prior, 0.5)
        params, sigma = fit.params, fit.sigma
    if second and len(params) < 4:
        params = np.append(params, 0.0)
    lines = []
    for view, g in zip(views, groups, strict=True):
        labels = followed(view.edges, g.labels, g.count, view.step) if second else g.labels
        found, own = view.edges.points[labels >= 0], labels[labels >= 0]
        found, own = with_outer_lines(view, found, own, params, replace(spec, distance=distance))
        lines.append((found, merge_twins(found, own, params, TWINS) if len(own) else own))
    return fit_measured(views, lines, params, sigma, reach, prior, content)


def _scouts(edges: EdgePoints, share: float) -> EdgePoints:
    if share >= 1:
        return edges
    chosen = np.random.default_rng(0).permutation(len(edges))[: int(len(edges) * share)]
    return edges.take(np.sort(chosen))


def _group(views: Sequence[View], params: Floats, spec: LineSpec) -> list[Grouping]:
    return [group(view.edges, params, spec) for view in views]


def _on_lines(views: Sequence[View], groups: Sequence[Grouping]) -> tuple[Floats, Labels]:
    """All points on lines, line after line, with labels that differ between views."""
    points, labels, count = [], [], 0
    for view, g in zip(views, groups, strict=True):
        points.append(view.edges.points[g.assigned])
        labels.append(g.labels[g.assigned] + count)
        count += g.count
    all_labels = np.concatenate(labels)
    order = np.argsort(all_labels, kind="stable")
    return np.concatenate(points)[order], all_labels[order]
