"""The lines that a person would choose: those of ``--lines``, else those that our own line finder sees."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...errors import CalibrationError
from ..fit.grouping import LineSpec, group
from ..fit.refine import best_start, reach_of
from ..straightness import Floats
from .task import Task

# How near to its line a point must be, px, and how nearly along it.
DISTANCE, ANGLE = 2.0, np.deg2rad(6)
# A line needs so many points, over this share of the points' reach.
FEWEST_POINTS, SHORTEST_SPAN = 25, 0.3


def chosen_lines(task: Task) -> Sequence[Floats]:
    """Return the points (n, 2) px of each line, the one of most points first.

    Lines that somebody chose come as they are, in their order. CalibrationError where no line is found.
    """
    if task.lines is not None:
        return task.lines
    reach = reach_of(task.views, task.prior.center)
    start = best_start(task.views, np.array([0.0, *task.prior.center]), reach, task.prior)
    lines: list[Floats] = []
    if start is not None:
        spec = LineSpec(DISTANCE, ANGLE, FEWEST_POINTS, SHORTEST_SPAN * reach)
        for view in task.views:
            found = group(view.edges, start, spec)
            lines += [view.edges.points[found.labels == i] for i in range(found.count)]
    if not lines:
        raise CalibrationError(
            "no straight lines found: show a sharp chessboard or straight lines, or choose with --lines"
        )
    return sorted(lines, key=len, reverse=True)
