"""The two Hough maps of the article, to be looked at: H1 (eq. 2-9) and H2 (eq. 10-14) of edge points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..straightness import Floats, Undistorted
from .heplp import SecondMap

# Cells of the maps: over half a turn, and across H1's offsets.
ANGLES, OFFSETS = 180, 240
# H1 shows offsets up to this many times that of nine votes in ten: all lines, but not the few points that
# land far out.
SHOWN = 1.3
# Points this near to the fold vote anywhere.
LEAST_DENOMINATOR = 0.05


@dataclass(frozen=True)
class VoteMaps:
    """Votes under one model.

    ``first`` (OFFSETS, ANGLES): by a line's offset r, from -``reach`` to ``reach`` px of the centre, and its
    normal's angle from 0 to pi; ``second`` (ANGLES, ANGLES): by rho and omega, each from 0 to pi.
    """

    first: Floats
    reach: float
    second: Floats


def vote_maps(
    points: Floats, gradients: Floats, params: Floats, size: tuple[float, float]
) -> VoteMaps:
    """Let edge points (n, 2) px with gradients (n, 2) vote under ``params`` (lam, cx, cy[, lam2]).

    ``size`` is the frame's (width, height) in px, which places P and Q of H2.
    """
    at = Undistorted.of(points, params)
    normals = at.gradients(gradients)
    held = at.denominator > LEAST_DENOMINATOR
    angle = np.arctan2(normals[held, 1], normals[held, 0])
    offset = np.einsum("ij,ij->i", at.u[held], normals[held])
    # A normal turned by half a turn has the opposite offset.
    offset = np.where(angle < 0, -offset, offset)
    angle = np.where(angle < 0, angle + np.pi, angle) % np.pi
    reach = SHOWN * float(np.quantile(np.abs(offset), 0.9)) if len(offset) else 1.0
    first, r_edges, angle_edges = np.histogram2d(
        offset, angle, (OFFSETS, ANGLES), ((-reach, reach), (0, np.pi))
    )
    row, column = np.nonzero(first)
    theta = (angle_edges[:-1] + angle_edges[1:])[column] / 2
    # H2's P, the top left pixel, is its origin.
    r = (r_edges[:-1] + r_edges[1:])[row] / 2
    r = r + params[1] * np.cos(theta) + params[2] * np.sin(theta)
    middle = ((size[0] - 1) / 2, (size[1] - 1) / 2)
    votes = first[row, column].astype(np.intp)
    second = SecondMap(middle, ANGLES, ANGLES).votes(theta, r, votes)
    return VoteMaps(first, reach, second.T)
