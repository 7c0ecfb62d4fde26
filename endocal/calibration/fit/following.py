"""Lines followed to their ends in the picture as it is.

Towards the pole of a model the corrected picture magnifies what the model gets wrong, and turns the
directions of edges by several times their error: the ends of a line vote elsewhere, or lie too far off it.
In the picture as it is they simply go on.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ..image.edges import EdgePoints
from ..straightness import Floats, Labels

# All px are those of the picture that edges were sought on.
# A line goes on as the parabola through its last so many px does, if it has so many points there.
TAIL, FEWEST_IN_TAIL = 40.0, 12
# What goes on begins within so many px, since an edge is not told near a crossing; in each step it has at
# least so many points, so near to the parabola, px, and so nearly in its direction.
AHEAD, FEWEST_AHEAD = 16.0, 4
ASIDE, ASLANT = 1.5, np.deg2rad(8)
# Of its length as it was found, the most that a line is followed at each end.
FARTHEST = 0.4


def followed(edges: EdgePoints, labels: Labels, count: int, step: int = 1) -> Labels:
    """Return labels (n,) of edge points, -1 for none, with those added at the ends of the ``count`` lines.

    Edges were sought on the picture reduced ``step`` times.
    """
    labels = labels.copy()
    edges = EdgePoints(edges.points / step, edges.gradients)
    free = labels < 0
    tree = cKDTree(edges.points)
    for line in range(count):
        own = np.flatnonzero(labels == line)
        points = edges.points[own]
        chord = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][0]
        order = np.argsort(points @ chord)
        length = float(np.linalg.norm(points[order[-1]] - points[order[0]]))
        for ends in (own[order], own[order[::-1]]):
            for added in _beyond(edges, tree, ends, free, FARTHEST * length):
                labels[added] = line
                free[added] = False
    return labels


def _beyond(
    edges: EdgePoints, tree: cKDTree, line: Labels, free: NDArray[np.bool_], most: float
) -> list[Labels]:
    """What follows the last of a line's points, indices in order, for up to ``most`` px: step by step."""
    added: list[Labels] = []
    start = edges.points[line[-1]]
    while True:
        end = edges.points[line[-1]]
        near = line[-int(2 * TAIL) :]
        tail = near[np.linalg.norm(edges.points[near] - end, axis=1) < TAIL]
        if len(tail) < FEWEST_IN_TAIL or np.linalg.norm(end - start) > most:
            return added
        ahead = np.array(tree.query_ball_point(end, AHEAD), np.intp)
        ahead = ahead[free[ahead]]
        if len(ahead) < FEWEST_AHEAD:
            return added
        along, on_course = _on_course(edges, tail, ahead)
        if np.count_nonzero(on_course) < FEWEST_AHEAD:
            return added
        step = ahead[on_course][np.argsort(along[on_course])]
        added.append(step)
        line = np.concatenate([line, step])


def _on_course(edges: EdgePoints, tail: Labels, ahead: Labels) -> tuple[Floats, NDArray[np.bool_]]:
    """How far (k,) px points lie beyond a tail, in order along its line, and which go on as it does."""
    end = edges.points[tail[-1]]
    way = end - edges.points[tail[0]]
    way /= np.linalg.norm(way)
    across = np.array([-way[1], way[0]])
    curve = np.polynomial.Polynomial.fit(
        (edges.points[tail] - end) @ way, (edges.points[tail] - end) @ across, 2
    )
    x, y = (edges.points[ahead] - end) @ way, (edges.points[ahead] - end) @ across
    slope = curve.deriv()(x)
    gradients = edges.gradients[ahead]
    turned = gradients @ across - slope * (gradients @ way)
    turned /= np.hypot(1, slope) * np.linalg.norm(gradients, axis=1)
    return x, (x > 0) & (np.abs(y - curve(x)) < ASIDE) & (np.abs(turned) > np.cos(ASLANT))
