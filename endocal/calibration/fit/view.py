"""One picture, or one field of an interlaced one, and the lines as they are measured in it.

All coordinates are in square pixels.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ..board.bars import bars_of
from ..image.edges import EdgePoints
from ..image.picture import Grey
from ..measure.bent import out_of_the_bend
from ..measure.light import Light, fitted_drawn, out_of_the_light, steepest_drawn
from ..measure.matched import blurs, measure_matched
from ..measure.own_rows import on_own_rows
from ..measure.profiles import SMOOTHING, Measured, measure, smoothed
from ..straightness import Floats, Labels
from .end_rows import end_rows, new_lines

# Fewer points than these tell nothing of the light.
FEWEST_POINTS = 12


@dataclass(frozen=True)
class View:
    """What is seen in one field: grey levels (h, w), edge points, and the number of its picture.

    Edges were sought on the picture reduced ``step`` times: there is one point for so many px along them.
    ``outer``: edge points in the dark surround or close to it, of which most are the rim's. ``first_row``: of
    the rows that a field has, every second one; None where the picture has them all.
    """

    grey: Grey
    edges: EdgePoints
    picture: int = 0
    step: int = 1
    outer: EdgePoints = field(default_factory=EdgePoints.none)
    first_row: int | None = None

    @cached_property
    def smooth(self) -> Grey:
        """The grey levels smoothed, as ``profiles.measure`` samples them."""
        return smoothed(self.grey)

    @property
    def edge_length(self) -> int:
        """How long the edges are in all, px."""
        return len(self.edges) * self.step


def measured_in(view: View, points: Floats, labels: Labels, params: Floats) -> Measured:
    """Measure the lines through ``points`` (n, 2) px with ``labels`` (n,) where a model has them."""
    if len(points) == 0:
        return Measured.none()
    return measure(view.smooth, points, labels, params).renumbered()


def with_end_rows(view: View, lines: Measured, params: Floats) -> Measured:
    """Add to the lines of a view the rows of bars' ends that were not among them."""
    rows = measured_in(view, *end_rows(view.edges, lines, params), params)
    if len(rows.points) == 0:
        return lines
    rows = rows.take(np.isin(rows.labels, new_lines(rows, lines)))
    if len(rows.points) == 0:
        return lines
    count = int(lines.labels.max()) + 1
    return Measured.joined([lines, rows], np.concatenate([lines.labels, rows.labels + count]))


def measured_again(
    view: View, lines: Measured, params: Floats, board: bool, noisy: bool
) -> Measured:
    """Measure the lines of a view where they were measured before."""
    if len(lines.points) == 0:
        return lines
    if not board:
        bars = bars_of(lines, params)
        light = (
            None
            if bars is None
            else Light.of(lines.take(np.isin(lines.labels, bars.edges)), params)
        )
        again = measure_matched(view.grey, view.smooth, lines, params, light)
        return _on_own_rows(view, again, params)
    again = measure(view.smooth, lines.points, lines.labels, params, True, noisy).renumbered()
    if len(again.points) < FEWEST_POINTS:
        return again
    blur = blurs(view.smooth, again, params)
    again = out_of_the_bend(again, blur**2 + SMOOTHING**2, params)
    light = Light.of(again, params)
    drawn = fitted_drawn(blur) if noisy else steepest_drawn(blur, SMOOTHING, light.gamma)
    again = out_of_the_light(again, drawn, blur, SMOOTHING, params, light)
    return _on_own_rows(view, again, params)


def _on_own_rows(view: View, lines: Measured, params: Floats) -> Measured:
    if view.first_row is None:
        return lines
    return on_own_rows(view.grey, view.first_row, lines, params)
