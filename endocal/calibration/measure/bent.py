"""Points put back on bent edges: blur draws the edge of anything round toward the middle of its bend.

An edge bent by a curvature k moves by k w^2 / 2 toward its hollow side when it is blurred by w (P. W. Verbeek
and L. J. van Vliet, IEEE TPAMI 16(7), 726-733, 1994).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..straightness import Floats
from .courses import normals_of
from .profiles import BETWEEN, Measured


def out_of_the_bend(lines: Measured, blurred: Floats, params: Floats) -> Measured:
    """Return the points with what blur draws them off taken away.

    ``blurred`` (count,) px^2: the variance of all that blurs the edge of each line, in the picture and since;
    ``params``: the model under which the lines run, see ``profiles.measure``.
    """

    def across(points: Floats) -> Floats:
        return normals_of(points, lines.labels, lines.points, lines.labels, params)

    normals = across(lines.points)
    along = np.stack([normals[:, 1], -normals[:, 0]], axis=1)
    # The normal turns by the curvature as one goes a px along the edge.
    turned = (across(lines.points + along) - across(lines.points - along)) / 2
    curvature = -np.einsum("ij,ij->i", turned, along)
    off = curvature * (blurred[lines.labels] + BETWEEN) / 2
    return replace(lines, points=lines.points - off[:, None] * normals)
