"""Straight edges before a background as black as the surround of the picture.

Where no circle is found, the dark that touches a corner of the frame is taken for surround, and what lies
close to it for the rim: a sheet before something black loses its edges. A rim, a circle about the middle or
a mask's straight side, is not straight under the model: an edge that is, over a length at which a rim would
be seen to depart, is none.
"""

from __future__ import annotations

import numpy as np

from ..straightness import Floats, Labels, residuals
from .grouping import LineSpec, group
from .view import View

# A line is told from a rim where one would leave it by so many px, several times what an edge point is off,
# and it does not itself leave the model's line by this share of that.
TOLD_APART, LEFT = 1.0, 0.25


def with_outer_lines(
    view: View, points: Floats, labels: Labels, params: Floats, spec: LineSpec
) -> tuple[Floats, Labels]:
    """Add to a view's lines, points (n, 2) px with labels (n,), those in the surround that are no rim's."""
    if len(view.outer) < spec.points:
        return points, labels
    found = group(view.outer, params, spec)
    count = int(labels.max()) + 1 if len(labels) else 0
    for line in range(found.count):
        own = view.outer.points[found.labels == line]
        if _no_rim(own, params):
            points = np.concatenate([points, own])
            labels = np.concatenate([labels, np.full(len(own), count, np.intp)])
            count += 1
    return points, labels


def _no_rim(points: Floats, params: Floats) -> bool:
    """Whether ``points`` (n, 2) on a line, straight under ``params``, can lie on no rim.

    What else they could lie on is told by its curvature: a circle about the distortion centre has that of its
    radius, a straight side has none, and the line, seen through the lens, another.
    """
    middle = points.mean(axis=0)
    chord = np.linalg.svd(points - middle, full_matrices=False)[2][0]
    along, across = (points - middle) @ chord, (points - middle) @ [-chord[1], chord[0]]
    half = float(np.ptp(along)) / 2
    left = residuals(points, np.zeros(len(points), np.intp), params)
    # How far the middle of an arc lies off its ends: px, of what is seen, and of it from the model's line.
    sagitta, bent = (half**2 * abs(np.polyfit(along, off, 2)[0]) for off in (across, left))
    radius = float(np.median(np.linalg.norm(points - params[1:3], axis=1)))
    apart = min(sagitta, half**2 / (2 * radius) - sagitta)
    return bool(apart > TOLD_APART and bent < LEFT * apart)
