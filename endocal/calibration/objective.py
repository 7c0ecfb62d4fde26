"""What a method is given of a scene: where to look, and what Algorithm 1 minimises there."""

from __future__ import annotations

import numpy as np

from ..errors import UsageError
from .fit.refine import reach_of
from .methods.registry import HEWG, method_named
from .methods.task import MOST_POINTS, Task
from .scene import Scene
from .search import Measure, Region
from .spec import CalibrationSpec
from .straightness import Floats

# Where Algorithm 1 only finds a start, so many points vote at most, drawn evenly.
MOST_VOTERS_FOR_START = 2_500
# The search ends where lambda is as good as zero, px^-2 (Lee et al. 2013: [-1 / r_max^2, -1e-7]); in larger
# pictures, of which it would leave nothing, at what that is in one whose edges reach so many px.
SMALLEST_LAMBDA = -1e-7
LARGE_REACH = 1100.0


def task_of(scene: Scene, spec: CalibrationSpec) -> Task:
    """Return what the method that ``spec`` names is given."""
    most = MOST_VOTERS_FOR_START if spec.refine else MOST_POINTS
    lines = _chosen(scene, spec)
    return Task(scene.views, scene.square_size, region_of(scene), scene.prior, spec, lines, most)


def cost_of(scene: Scene, spec: CalibrationSpec) -> Measure:
    """Return the entropy that is minimised, averaged over the views.

    HEwG's where the method that ``spec`` names minimises none.
    """
    return (method_named(spec.method).measure or HEWG).over(task_of(scene, spec))


def region_of(scene: Scene) -> Region:
    """Return where it is sought: lambda within the reach of the edges, the centre about the middle."""
    reach = reach_of(scene.views, scene.prior.center)
    x, y = scene.prior.center
    dx, dy = scene.prior.spread
    smallest = SMALLEST_LAMBDA * min(1.0, LARGE_REACH / reach) ** 2
    return Region((-1 / reach**2, smallest), (x - dx, x + dx), (y - dy, y + dy))


def _chosen(scene: Scene, spec: CalibrationSpec) -> list[Floats] | None:
    """The chosen lines in square pixels."""
    if spec.lines is None:
        return None
    w, h = scene.size
    for number, line in enumerate(spec.lines, 1):
        for x, y in line:
            if not (0 <= x <= w - 1 and 0 <= y <= h - 1):
                raise UsageError(
                    f"--lines: line {number} leaves the {w}x{h} px picture at {x:g},{y:g}"
                )
    return [np.array(line) * (spec.aspect, 1.0) for line in spec.lines]
