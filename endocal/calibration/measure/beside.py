"""Points of an edge that others beside it draw off its course, put back.

The steepest place of a blurred edge moves away from an edge of the other direction beside it, as those of a
narrow strip do, and toward one of its own. How far follows from the places and heights of the edges and the
blur: where a picture is even but for edges, its gradient is that of each edge, blurred, in sum.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from ..straightness import Floats, Labels
from .courses import leading, normals_of
from .profiles import AVERAGED, Measured

# Edges farther away than so many widths draw nothing off; those that turn from it by more than this cosine
# meet it at a corner, and do not run beside it.
FARTHEST, ALONG = 4.0, 0.7
# Steepest places are sought so far to both sides of an edge, in widths, in such steps.
ASIDE, STEP = 1.0, 0.05
# What is drawn off by more than so many px is not told well enough by how much.
MOST_OFF = 1.0
# The places of both edges are those that were measured first, and then those that were put back.
ROUNDS = 2
# A steepest place is told by slopes one px to both sides being alike: as if the step were wider by this
# variance, px^2.
TOLD_BY = 1 / 3


def put_back(
    lines: Measured, widths: Floats, params: Floats, steepness: Floats, rooms: Floats
) -> tuple[Measured, Labels]:
    """Return the points with what edges beside draw them off taken away, without those drawn off far.

    ``widths`` (count,) px: of each line's blurred step, its standard deviation as it was sampled;
    ``steepness`` (n,): its slope, grey levels per px; ``rooms`` (count,) px: how far away the next line runs
    beside each. Returns also which lines are left.
    """
    across = normals_of(lines.points, lines.labels, lines.points, lines.labels, params)
    concerned = np.flatnonzero(rooms < FARTHEST * widths)
    off = _drawn_off(lines, across, _heights(lines, steepness, widths), widths, concerned)
    clear = np.abs(off) < MOST_OFF
    moved = replace(lines, points=lines.points - off[:, None] * across)
    return moved.take(clear), np.unique(lines.labels[clear])


def _drawn_off(
    lines: Measured, across: Floats, heights: Floats, widths: Floats, concerned: Labels
) -> Floats:
    """How far (n,) px along the unit normals ``across`` (n, 2) points lie off their edges.

    ``heights`` (n,): grey levels that the edges rise by; ``concerned``: the lines that others are near to.
    """
    off = np.zeros(len(lines.points))
    bright = across * (leading(lines.points, lines.labels, across) * lines.sides)[:, None]
    sign = np.einsum("ij,ij->i", bright, across)
    for _ in range(ROUNDS):
        places = lines.points - off[:, None] * across
        tree = cKDTree(places)
        moved = off.copy()
        for line in concerned:
            own = np.flatnonzero(lines.labels == line)
            moved[own] = sign[own] * _steepest(
                own, places, bright, heights, lines.labels, tree, float(widths[line])
            )
        off = moved
    return off


def _steepest(
    own: Labels,
    places: Floats,
    bright: Floats,
    heights: Floats,
    labels: Labels,
    tree: cKDTree,
    width: float,
) -> Floats:
    """Where the steepest places of the points ``own`` (k,) are, px toward the bright side of their edge."""
    width = float(np.hypot(width, np.sqrt(TOLD_BY)))
    near = tree.query_ball_point(places[own], FARTHEST * width)
    row = np.repeat(np.arange(len(own)), [len(n) for n in near])
    other = np.concatenate([np.asarray(n, np.intp) for n in near])
    alike = np.einsum("ij,ij->i", bright[own][row], bright[other])
    chosen = (labels[other] != labels[own][0]) & (np.abs(alike) > ALONG)
    row, other, alike = row[chosen], other[chosen], alike[chosen]
    way = places[other] - places[own][row]
    away = np.einsum("ij,ij->i", way, bright[own][row])
    beside = np.einsum("ij,ij->i", way, way) - away**2
    wide = np.hypot(width, np.sqrt(AVERAGED))
    share = alike * heights[other] / heights[own][row]
    share *= np.exp(-0.5 * beside / wide**2) / (np.sqrt(2 * np.pi) * wide)
    at = np.arange(-ASIDE, ASIDE + STEP / 2, STEP) * width
    steep = np.repeat(np.exp(-0.5 * (at / width) ** 2)[None], len(own), axis=0)
    slopes = share[:, None] * np.exp(-0.5 * ((at - away[:, None]) / width) ** 2)
    for column in range(len(at)):
        steep[:, column] += np.bincount(row, slopes[:, column], len(own))
    top = np.clip(steep.argmax(axis=1), 1, len(at) - 2)
    before, here, after = (steep[np.arange(len(own)), top + i] for i in (-1, 0, 1))
    bend = np.minimum(before - 2 * here + after, -1e-12)
    return np.asarray(at[top] + STEP * width * np.clip((before - after) / 2 / bend, -1, 1))


def _heights(lines: Measured, steepness: Floats, widths: Floats) -> Floats:
    """Heights (n,) of edges in grey levels, from the slopes (n,) of their blurred steps."""
    return np.asarray(steepness * np.sqrt(2 * np.pi) * widths[lines.labels])
