"""Rows of the ends of bars, told by where the bars' own edges end.

Blur rounds the end of a narrow bar: hardly any of its edge points have the direction of the row that the
ends lie on, and no peak of the vote map shows it. But where an edge of a bar ends, the end of the bar is
near, and such places of many bars lie on one line.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ..image.edges import EdgePoints
from ..measure.profiles import Measured
from ..straightness import Floats, Labels, Undistorted, fit_lines

# Edge points that lie farther than so many px from all lines are on none of them; those so near to where a
# line ends may be on the end of its bar.
OFF_LINES, NEAR_END = 2.5, 12.0
# A row meets the ends of so many lines or more, two to a bar, and lies so near to them, px.
FEWEST_ENDS, NEAR_ROW = 6, 1.5
# A measured row with this share of its points so near to those of lines, px, is one of these.
AGAIN, MOST_AGAIN = 1.5, 0.3
# No more rows than a sheet of bars has are looked for: none of 55 showed more, and it bounds the work on what
# is no sheet of bars.
MOST_ROWS = 2


def end_rows(edges: EdgePoints, lines: Measured, params: Floats) -> tuple[Floats, Labels]:
    """Points (n, 2) px with labels (n,) from 0, of rows of ends that no line of ``lines`` follows.

    They are straight under ``params``. A point is the middle of what is seen of an end beside one edge.
    """
    if len(lines.points) == 0 or len(edges) == 0:
        return np.empty((0, 2)), np.empty(0, np.intp)
    starts = np.flatnonzero(np.diff(lines.labels, prepend=-1))
    tips = lines.points[np.append(starts, np.append(starts[1:], len(lines.labels)) - 1)]
    off, _ = cKDTree(lines.points).query(edges.points)
    away, tip = cKDTree(tips).query(edges.points)
    free = (off > OFF_LINES) & (away < NEAR_END)
    points, tip = edges.points[free], tip[free]
    count = np.maximum(np.bincount(tip, minlength=len(tips)), 1)
    middles = np.stack([np.bincount(tip, x, len(tips)) / count for x in points.T], axis=1)
    middles = middles[np.unique(tip)]
    rows: list[Floats] = []
    while len(rows) < MOST_ROWS and len(middles) >= FEWEST_ENDS:
        on_row = _best_row(middles, params)
        if np.count_nonzero(on_row) < FEWEST_ENDS:
            break
        rows.append(middles[on_row])
        middles = middles[~on_row]
    labels = np.repeat(np.arange(len(rows)), [len(row) for row in rows])
    return np.concatenate([np.empty((0, 2)), *rows]), labels


def new_lines(rows: Measured, lines: Measured) -> Labels:
    """Return the labels of measured ``rows`` that are none of the ``lines`` measured again."""
    off, _ = cKDTree(lines.points).query(rows.points)
    again = np.bincount(rows.labels, off < AGAIN) / np.bincount(rows.labels)
    return np.flatnonzero(again < MOST_AGAIN)


def _best_row(middles: Floats, params: Floats) -> NDArray[np.bool_]:
    """Which places (n,) lie on the line through two of them that meets most; then on the line fitted."""
    under = Undistorted.of(middles, params)
    first, second = np.triu_indices(len(middles), 1)
    ways = under.u[second] - under.u[first]
    normals = np.stack([-ways[:, 1], ways[:, 0]], axis=1)
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-9)[:, None]
    offsets = np.einsum("ij,ij->i", normals, under.u[first])
    near = np.abs(normals @ under.u.T - offsets[:, None]) * under.denominator < NEAR_ROW
    best = near[near.sum(axis=1).argmax()]
    line = fit_lines(under.u[best], np.zeros(best.sum(), np.intp), 1, under.denominator[best] ** 2)
    off = np.abs(under.u @ line.normals[0] - line.offsets[0]) * under.denominator
    return np.asarray(off < NEAR_ROW)
