"""The direction of an edge at each of its points, from the points along it.

A gradient, however large its mask, tells a direction from the grey levels at one place of the edge, and
noise on them turns it by half a degree and more. The sub-pixel points of the same edge to both sides tell it
better: the straight line through those within reach has half the error or less, and the point moved onto it
less noise across the edge. A bent edge does no harm as long as the points lie to both sides evenly, since its
tangent is parallel to the chord; where they do not, at the end of a square's side, the direction is not told.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ..straightness import Floats, Labels
from .edges import EdgePoints

# A point of the same edge lies at most so far, px and share of the distance, off the direction known ...
ASIDE, ASIDE_SHARE = 1.0, 0.15
# ... and its normal is that of the edge to this cosine, the same side being bright.
ALIKE = 0.85
# An edge's direction is told by so many points, whose mean lies within this share of the reach, and which
# turn what was known by less than this tangent.
FEWEST, EVENNESS, MOST_TURN = 4, 0.35, 0.5
# Points that are worked on at once.
BLOCK = 4096


def directions_along(
    edges: EdgePoints, chosen: Labels, reach: float
) -> tuple[EdgePoints, NDArray[np.bool_]]:
    """Return some edge points (m,) moved onto the lines along their edges, with those lines' normals.

    ``edges`` have normals with the bright side ahead, to a few degrees; ``chosen`` (m,) says which points are
    asked for; the line is that of the points within ``reach`` px along the edge. The second, (m,), is whether
    a point's direction is told; one that is not comes as it was.
    """
    tree = cKDTree(edges.points)
    # The points of the edge itself, 1 px apart or more, and as many of others.
    most = min(2 * (2 * int(np.ceil(reach)) + 1), len(edges))
    points, normals = edges.points[chosen].copy(), edges.gradients[chosen].copy()
    told = np.zeros(len(chosen), bool)
    for start in range(0, len(chosen), BLOCK):
        part = slice(start, start + BLOCK)
        distance, near = tree.query(
            points[part], np.arange(1, most + 1), distance_upper_bound=reach
        )
        slope, offset, told[part] = _lines(edges, chosen[part], near, np.isfinite(distance), reach)
        n = normals[part]
        tangents = np.stack([-n[:, 1], n[:, 0]], axis=1)
        points[part] += offset[:, None] * n
        turned = n - slope[:, None] * tangents
        normals[part] = turned / np.linalg.norm(turned, axis=1)[:, None]
    return EdgePoints(points, normals), told


def _lines(
    edges: EdgePoints, chosen: Labels, near: Labels, there: NDArray[np.bool_], reach: float
) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Slope and offset, px, of the least-squares line in each point's own frame, and whether it counts.

    ``near`` (m, k) are the points around, where ``there`` is set. Where it does not count both are 0.
    """
    near = np.where(there, near, chosen[:, None])
    d = edges.points[near] - edges.points[chosen][:, None]
    normal = edges.gradients[chosen][:, None]
    across = (d * normal).sum(axis=-1)
    along = d[..., 1] * normal[..., 0] - d[..., 0] * normal[..., 1]
    own = there & (np.abs(across) < ASIDE + ASIDE_SHARE * np.abs(along))
    own &= (edges.gradients[near] * normal).sum(axis=-1) > ALIKE
    count = own.sum(axis=1)
    along, across = np.where(own, along, 0), np.where(own, across, 0)
    t, o = along.sum(axis=1) / np.maximum(count, 1), across.sum(axis=1) / np.maximum(count, 1)
    spread = (along**2).sum(axis=1) - count * t**2
    slope = ((along * across).sum(axis=1) - count * t * o) / np.maximum(spread, 1e-9)
    told = (count >= FEWEST) & (np.abs(t) < EVENNESS * reach) & (np.abs(slope) < MOST_TURN)
    return np.where(told, slope, 0), np.where(told, o - slope * t, 0), told
