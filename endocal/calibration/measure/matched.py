"""Lines measured on a picture that is smoothed as their own blur and length want it.

Of a step blurred by s and smoothed by S, white noise moves the steepest place by a variance in proportion to
(S^2 + s^2)^3 / S^5: least at S = sqrt(5) s. Smoothing the sharp edges of one picture and the soft ones of the
next alike moves points up to twice as far as they must be moved. But more smoothing sees more of what lies
beside an edge, and of the corners at its ends: the rule below stays on the narrow side of that least.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from ..image.picture import Grey
from ..image.sampling import sample_smoothly
from ..straightness import Floats, Labels
from .bent import out_of_the_bend
from .beside import put_back
from .courses import normals_of
from .edge_ends import on_their_edges
from .light import Light, out_of_the_light, steepest_drawn
from .profiles import (
    BETWEEN,
    DIFFERENCES,
    SMOOTHING,
    Measured,
    measure,
    smoothed,
    usual_of,
)

# Smoothing over blur: noise then moves points 4 % farther than at the least, with a quarter less smoothing.
OVER_BLUR = 1.7
# Smoothing, px, at least and at most, in steps of which two neighbours differ little.
SCALES = np.array([0.9, 1.2, 1.6, 2.0, 2.5])
# An edge is as long as this many times the smoothing: what the corners of a bar's short end leave of it is
# otherwise too little. But with less smoothing than blur, noise moves points farther than corners do.
LENGTHS = 10.0
# The next edge beside a line is so many times as far away as the edge is wide once smoothed, or farther: then
# it moves the steepest place by two hundredths of that width, which ``beside`` takes off.
ROOM = 3.2
# Rooms are told at every so many-th point, among so many neighbours; a neighbour lies across the line where
# the way there is so much that of the normal (a cosine). A line's room is this quantile of its points'.
SPARSE, NEIGHBORS, ACROSS, TIGHTEST = 4, 24, 0.8, 0.1
# Lines that turn from each other by more than this cosine meet at a corner, and do not run beside each other.
ALONG = 0.9
# A line's blur is told where its edge is steeper than this share of what is usual on it.
STEEP = 0.85
# A blur, px, is no narrower than what a pixel's own area makes of a sharp edge.
SHARPEST = np.sqrt(1 / 12)


def measure_matched(
    grey: Grey, smooth: Grey, lines: Measured, params: Floats, light: Light | None = None
) -> Measured:
    """Measure ``lines`` again where they were measured, each on ``grey`` smoothed to suit it.

    ``smooth``: ``grey`` as ``profiles.smoothed`` gives it; ``params``: see ``profiles.measure``; ``light``:
    that on the sheet they are printed on, where that is known.
    """
    blur, room = blurs(smooth, lines, params), rooms(lines, params)
    free = np.sqrt(np.maximum((room / ROOM) ** 2 - blur**2, SCALES[0] ** 2))
    short = np.maximum(usual_lengths(lines) / LENGTHS, 0.7 * blur)
    wanted = np.minimum(np.minimum(OVER_BLUR * blur, short), free)
    scale = SCALES[np.abs(np.log(SCALES / wanted[:, None])).argmin(axis=1)]
    parts = []
    for size in np.unique(scale):
        own = (scale == size)[lines.labels]
        numbers, labels = np.unique(lines.labels[own], return_inverse=True)
        part = measure(smoothed(grey, size), lines.points[own], labels, params, follow=True)
        parts.append((part, numbers[part.labels]))
    widths = np.sqrt(scale**2 + blur**2 + DIFFERENCES + BETWEEN)
    whole, numbers = _in_line_order(parts)
    size, blur = scale[numbers], blur[numbers]
    # For the smoothing a slope is less steep, and noise is less.
    told = whole.information * (size**5 / (size**2 + blur**2) ** 2)[whole.labels]
    steepness = np.sqrt(whole.information)
    whole = replace(whole, information=told)
    whole = out_of_the_bend(whole, blur**2 + size**2, params)
    if light is not None:
        # Levels are read on the picture as smoothed for the line.
        drawn = steepest_drawn(blur, size, light.gamma)
        whole = out_of_the_light(whole, drawn, blur, size, params, light)
    whole, left = put_back(whole, widths[numbers], params, steepness, room[numbers])
    return on_their_edges(whole, widths[numbers][left], params)


def blurs(smooth: Grey, lines: Measured, params: Floats) -> Floats:
    """The blur of each line's edge in the picture before it was smoothed, px, its standard deviation.

    The slope of a blurred step is a Gaussian: its means along a line, there and 1 px beside, tell its width.
    """
    count = int(lines.labels.max()) + 1
    # Near a crossing at a slant an edge is narrower, and not as steep.
    usual = usual_of(lines.information, lines.labels, count)[lines.labels]
    steep = lines.information >= STEEP**2 * usual
    across = normals_of(lines.points, lines.labels, lines.points, lines.labels, params)[steep]
    offsets = np.arange(-2.0, 3.0)
    levels = sample_smoothly(smooth, lines.points[steep, None] + offsets[:, None] * across[:, None])
    slopes = (levels[:, 2:] - levels[:, :-2]).astype(np.float64)
    slopes *= np.sign(slopes[:, 1])[:, None]
    before, at, after = (np.bincount(lines.labels[steep], column, count) for column in slopes.T)
    beside = np.clip((before + after) / 2 / np.maximum(at, 1e-9), 1e-3, 0.999)
    variance = -0.5 / np.log(beside) - DIFFERENCES - BETWEEN - SMOOTHING**2
    return np.sqrt(np.maximum(variance, SHARPEST**2))


def rooms(lines: Measured, params: Floats) -> Floats:
    """How far, px, the nearest other line runs beside each; infinite where none is near."""
    points, labels = lines.points[::SPARSE], lines.labels[::SPARSE]
    across = normals_of(points, labels, lines.points, lines.labels, params)
    farthest = ROOM * np.hypot(SCALES[-1], SCALES[-1] / OVER_BLUR)
    away, near = cKDTree(points).query(points, NEIGHBORS, distance_upper_bound=farthest)
    near = np.minimum(near, len(points) - 1)
    beside = np.abs(np.einsum("ikj,ij->ik", points[near] - points[:, None], across)) > ACROSS * away
    alike = np.abs(np.einsum("ikj,ij->ik", across[near], across)) > ALONG
    beside &= alike & (labels[near] != labels[:, None])
    room = np.where(beside, away, np.inf).min(axis=1)
    return np.array(
        [
            np.quantile(room[labels == i], TIGHTEST, method="lower") if np.any(labels == i) else 0
            for i in range(int(lines.labels.max()) + 1)
        ]
    )


def usual_lengths(lines: Measured) -> Floats:
    """How long, px, the edges are that make up each line: half of its points lie on longer ones."""
    steps = np.linalg.norm(np.diff(lines.points, axis=0, prepend=lines.points[:1]), axis=1)
    begins = lines.edge_starts()
    edge = np.cumsum(begins) - 1
    length = np.bincount(edge, np.where(begins, 0.0, steps))[edge]
    count = int(lines.labels.max()) + 1
    return np.array([np.median(length[lines.labels == i]) for i in range(count)])


def _in_line_order(parts: list[tuple[Measured, Labels]]) -> tuple[Measured, Labels]:
    """The points of all parts, line after line, labels renumbered from 0, and what these were before."""
    labels = np.concatenate([own for _, own in parts])
    order = np.argsort(labels, kind="stable")
    before, numbered = np.unique(labels[order], return_inverse=True)
    whole = Measured.joined([part for part, _ in parts], labels)
    return whole.in_order(order, numbered.astype(np.intp)), before
