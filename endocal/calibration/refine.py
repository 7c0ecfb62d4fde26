"""From edge points to a model: starting points, grouping into lines, measuring them, the final fit.

All coordinates are in square pixels. A *view* is one picture, or one field of an interlaced one: the
views of a lens share its model, and keep their lines apart.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .edges import EdgePoints
from .fit import Fit, Prior, fit_model
from .lines import Grouping, LineSpec, group
from .pattern import board_lines, merge_twins
from .picture import Grey
from .profiles import Measured, measure, smooth_for_profiles
from .straightness import Floats, Labels

# Where the fit is started besides the search's answer: lambda times the squared reach of the points.
STARTS = (-1.4, -0.9, -0.4, 0.0)
# Points that the starts are compared on; all of them serve from then on.
SCOUTS = 3000
# How near to its line a point must be, px, in the rounds of a start, and in those of the one that won.
START_ROUNDS = (5.0, 3.5, 2.5)
START_JUDGED = 2.0
GROUP_ROUNDS = (2.0, 1.5)
# Of the points' reach: the shortest span of a line. Points a line needs at least.
SHORTEST_SPAN = 0.08
FEWEST_POINTS = 25
FEWEST_LINES = 3
# Profiles reach this far to both sides of a line, px, and lines nearer than TWINS px are one.
PROFILE_REACH = 3
TWINS = 1.0


@dataclass(frozen=True)
class View:
    """What is seen in one field: grey levels (h, w), edge points, and the number of its picture."""

    grey: Grey
    edges: EdgePoints
    picture: int = 0


@dataclass(frozen=True)
class Refined:
    """A fit with the measured points it rests on; ``view`` (n,) tells which view each is from."""

    fit: Fit
    measured: Measured
    view: Labels


def reach_of(views: Sequence[View], center: tuple[float, float]) -> float:
    """The distance in px within which nearly all edge points lie from ``center``."""
    return max(
        float(np.quantile(np.linalg.norm(v.edges.points - center, axis=1), 0.98)) for v in views
    )


def best_start(
    views: Sequence[View], starts: Sequence[Floats], reach: float, prior: Prior
) -> Floats | None:
    """Improve each start by grouping and fitting in turn; return where most points end up on few lines.

    What is compared is the entropy of the lines' shares of the points, in distorted px: unlike that of a
    vote map, it does not fall when a model shrinks the picture. None where no start finds a line.
    """
    total = sum(len(v.edges) for v in views)
    share = min(1.0, SCOUTS / max(total, 1))
    scouts = [replace(v, edges=_scouts(v.edges, share)) for v in views]
    spec = LineSpec(0.0, np.deg2rad(8), max(10, int(FEWEST_POINTS * share)), SHORTEST_SPAN * reach)
    best: tuple[float, Floats] | None = None
    for start in starts:
        params = start
        for distance in START_ROUNDS:
            groups = _group(scouts, params, replace(spec, distance=distance))
            points, labels = _on_lines(scouts, groups)
            if len(points) == 0 or labels.max() + 1 < FEWEST_LINES:
                break
            softness = distance / 3
            params = fit_model(points, labels, params, reach, prior, softness, rounds=8).params
        groups = _group(scouts, params, replace(spec, distance=START_JUDGED))
        entropy = float(np.mean([g.entropy() for g in groups]))
        if sum(g.count for g in groups) >= FEWEST_LINES and (best is None or entropy < best[0]):
            best = entropy, params
    return None if best is None else best[1]


def refine(
    views: Sequence[View], start: Floats, reach: float, prior: Prior, second: bool = False
) -> Refined | None:
    """Fit the model from ``start``; with ``second``, lam2 too. None where too few lines hold."""
    params, sigma = start, 1.0
    spec = LineSpec(0.0, np.deg2rad(6), FEWEST_POINTS, SHORTEST_SPAN * reach)
    for distance in GROUP_ROUNDS:
        groups = _group(views, params, replace(spec, distance=distance))
        points, labels = _on_lines(views, groups)
        if len(points) == 0 or labels.max() + 1 < FEWEST_LINES:
            return None
        fit = fit_model(points, labels, params, reach, prior, 0.5)
        params, sigma = fit.params, fit.sigma
    if second:
        params = np.append(params, 0.0)
    lines = []
    for view, g in zip(views, groups, strict=True):
        found, own = view.edges.points[g.assigned], g.labels[g.assigned]
        lines.append((found, merge_twins(found, own, params, TWINS) if g.count else own))
    smooth = [smooth_for_profiles(view.grey) for view in views]
    for _ in range(2):
        parts = [
            _measure_board(s, *line, params) if len(line[0]) else Measured.none()
            for s, line in zip(smooth, lines, strict=True)
        ]
        everything, view_of = _joined(parts)
        if len(everything.points) == 0 or everything.labels.max() + 1 < FEWEST_LINES:
            return None
        fit = _fit(everything, params, reach, prior, max(0.1, sigma))
        params, sigma = fit.params, fit.sigma
        lines = [(part.points, part.labels) for part in parts]
    fit = _fit(everything, params, reach, prior, max(0.05, 2 * sigma))
    return Refined(fit, everything, view_of)


def _fit(m: Measured, start: Floats, reach: float, prior: Prior, softness: float) -> Fit:
    return fit_model(m.points, m.labels, start, reach, prior, softness, m.sides)


def _measure_board(smooth: Grey, points: Floats, labels: Labels, params: Floats) -> Measured:
    measured = measure(smooth, points, labels, params, PROFILE_REACH)
    if len(measured.points) == 0:
        return Measured.none()
    measured = measured.take(np.ones(len(measured.points), bool))
    return measured.take(board_lines(measured)[measured.labels])


def _scouts(edges: EdgePoints, share: float) -> EdgePoints:
    if share >= 1:
        return edges
    chosen = np.random.default_rng(0).permutation(len(edges))[: int(len(edges) * share)]
    return edges.take(np.sort(chosen))


def _group(views: Sequence[View], params: Floats, spec: LineSpec) -> list[Grouping]:
    return [group(view.edges, params, spec) for view in views]


def _on_lines(views: Sequence[View], groups: Sequence[Grouping]) -> tuple[Floats, Labels]:
    """All points on lines, with labels that differ between views."""
    points, labels, count = [], [], 0
    for view, g in zip(views, groups, strict=True):
        points.append(view.edges.points[g.assigned])
        labels.append(g.labels[g.assigned] + count)
        count += g.count
    return np.concatenate(points), np.concatenate(labels)


def _joined(parts: Sequence[Measured]) -> tuple[Measured, Labels]:
    count = 0
    labels = []
    for part in parts:
        labels.append(part.labels + count)
        count += int(part.labels.max()) + 1 if len(part.labels) else 0
    joined = Measured(
        np.concatenate([p.points for p in parts]),
        np.concatenate(labels),
        np.concatenate([p.sides for p in parts]),
    )
    return joined, np.repeat(np.arange(len(parts)), [len(p.points) for p in parts])
