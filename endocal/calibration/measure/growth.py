"""How far bright areas seem to grow: gamma and over-exposure move an edge toward its dark side.

How far depends on the grey levels of both sides, which light and vignetting change over the picture: an edge
that is bright on one side all along then seems bent. In columns of px by unit, fitted along with the model.
"""

from __future__ import annotations

import numpy as np

from ..straightness import Floats, Labels, two_sided

# Grey levels that vary by less than this tell nothing, nor what lies beyond so many of their spreads.
LEAST_SPREAD = 3.0
FARTHEST = 3.0


def growth_columns(sides: Floats, levels: Floats, labels: Labels) -> Floats:
    """Return (n, k) columns whose combination is how far points seem to be moved, across their lines.

    ``sides`` (n,), +1 or -1: on which side of its line, ``labels`` (n,), a point is bright; ``levels`` (n,
    m): grey levels that it may depend on, of its dark and bright side and of the light there.
    """
    columns = []
    # On lines seen from both sides the mean growth is told apart from place and bend for each.
    one_sided = sides - two_sided(sides, labels)
    if one_sided.min() < 0 < one_sided.max():
        columns.append(one_sided)
    if sides.min() < 0 < sides.max():
        usual = np.median(levels, axis=0)
        spread = np.maximum(levels.std(axis=0), LEAST_SPREAD)
        columns.extend(sides[:, None].T * np.clip((levels - usual) / spread, -FARTHEST, FARTHEST).T)
    return np.stack(columns, axis=1) if columns else np.empty((len(sides), 0))


def smooth_growth(points: Floats, sides: Floats) -> Floats:
    """Return (n, 6) columns by which growth of edges at ``points`` (n, 2) px may differ over the picture.

    A polynomial of second degree in their places, for whatever grey levels do not tell of it.
    """
    middle = points.mean(axis=0)
    x, y = ((points - middle) / np.abs(points - middle).max()).T
    return np.asarray(
        sides[:, None] * np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1)
    )
