"""What Algorithm 1 minimises over a scene, and where it looks."""

from __future__ import annotations

import numpy as np

from .edges import sobel_gradients
from .measures import NamedMeasure, measure_named
from .refine import View, reach_of
from .scene import Scene
from .search import Measure, Region
from .spec import CalibrationSpec
from .straightness import Floats

# Where Algorithm 1 only finds a start, so many points vote at most, drawn evenly.
MOST_VOTERS_FOR_START = 5_000
# The search ends where lambda is as good as zero, px^-2 (METHOD: [-1 / r_max^2, -1e-7]).
SMALLEST_LAMBDA = -1e-7


def cost_of(scene: Scene, spec: CalibrationSpec) -> Measure:
    """Return what is minimised: the measure that ``spec`` names, averaged over the views."""
    named = measure_named(spec.method)
    most = min(named.most_points, MOST_VOTERS_FOR_START if spec.refine else named.most_points)
    measures = [_measure(view, named, most, spec.sobel, scene.square_size) for view in scene.views]

    def cost(lams: Floats, xs: Floats, ys: Floats) -> Floats:
        return np.mean([measure(lams, xs, ys) for measure in measures], axis=0)

    return cost


def region_of(scene: Scene) -> Region:
    """Return where it is sought: lambda within the reach of the edges, the centre about the middle."""
    reach = reach_of(scene.views, scene.prior.center)
    x, y = scene.prior.center
    dx, dy = scene.prior.spread
    return Region((-1 / reach**2, SMALLEST_LAMBDA), (x - dx, x + dx), (y - dy, y + dy))


def _measure(
    view: View, named: NamedMeasure, most: int, sobel: int, size: tuple[float, float]
) -> Measure:
    """The measure over a view's edge points, at most ``most`` of them, drawn evenly."""
    edges = view.edges
    gradients = sobel_gradients(view.grey, edges.points, sobel)
    if len(edges) > most:
        chosen = np.random.default_rng(0).permutation(len(edges))[:most]
        edges, gradients = edges.take(chosen), gradients[chosen]
    return named.prepare(edges.points, gradients, size)
