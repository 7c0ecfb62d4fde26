"""Edges measured again, to sub-pixel, on profiles across the lines that a model predicts.

A line of a chessboard changes sides at every crossing. Its edge point on a profile across the *line* stays
unbiased there, where the gradient of the blurred crossing turns away from the line's normal.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from ..image.picture import Grey
from ..image.sampling import sample_smoothly
from ..straightness import Floats, Labels
from .courses import Courses, courses
from .step_edge import WIDEST, Steps, fit_steps

# Smoothing of the picture before profiles are taken, px (sigma). And how many neighbouring profiles along a
# line are averaged, with sign: that widens what lies along the line by this variance, px^2.
SMOOTHING = 1.2
NEIGHBORS = 5
AVERAGED = (NEIGHBORS**2 - 1) / 12
# What taking differences over two px, and sampling between pixels, add to the variance of a blur, px^2.
DIFFERENCES, BETWEEN = 1 / 3, 1 / 3
# Where a model says that a line runs, its edge is sought up to so many px to both sides; and so far beside
# it, px, the levels of both its sides are read.
REACH, BESIDE = 3, 4
# A profile counts where its edge has this share of the line's usual strength, this quantile: it has less near
# a crossing, and none between the ends of bars.
LEAST_STRENGTH, USUAL = 0.4, 0.75
# What is fitted to each line apart: its place, its direction, how far its two sides' edges lie apart.
FITTED_TO_A_LINE = 3
# Between two edges of a line lies a gap of more than so many px, or places where these are spaced wider.
GAP = 3.0


@dataclass(frozen=True)
class Measured:
    """Edge points in order along their lines.

    ``points`` (n, 2) px; ``labels`` (n,) of their lines; ``sides`` (n,), +1 where the left is bright as one
    goes along the line, -1 where the right is; ``levels`` (n, 3), grey levels of the dark and bright side,
    and of a white sheet there, as far as that is known; ``information`` (n,): the inverse of the variance
    that white noise gives a point, but for a factor that they share.
    """

    points: Floats
    labels: Labels
    sides: Floats
    levels: Floats
    information: Floats

    @classmethod
    def none(cls) -> Measured:
        """No point at all."""
        return cls(
            np.empty((0, 2)), np.empty(0, np.intp), np.empty(0), np.empty((0, 3)), np.empty(0)
        )

    def take(self, chosen: NDArray[np.bool_]) -> Measured:
        """Return some of the points, by mask, with labels renumbered from 0."""
        labels = np.unique(self.labels[chosen], return_inverse=True)[1].astype(np.intp)
        return self.in_order(np.flatnonzero(chosen), labels)

    def renumbered(self) -> Measured:
        """Return the same points, the labels of lines that have some numbered from 0."""
        return self.take(np.ones(len(self.points), bool))

    def in_order(self, order: Labels, labels: Labels) -> Measured:
        """Return the points at the indices ``order`` (m,), with new ``labels`` (m,)."""
        return Measured(
            self.points[order],
            labels,
            self.sides[order],
            self.levels[order],
            self.information[order],
        )

    @classmethod
    def joined(cls, parts: Sequence[Measured], labels: Labels) -> Measured:
        """Return the points of all parts, one part after the other, with new ``labels``."""
        return cls(
            np.concatenate([p.points for p in parts]),
            labels,
            np.concatenate([p.sides for p in parts]),
            np.concatenate([p.levels for p in parts]),
            np.concatenate([p.information for p in parts]),
        )

    def edge_starts(self) -> NDArray[np.bool_]:
        """Say of each point (n,) whether an edge begins there: a line, its other side, or after a gap."""
        steps = np.linalg.norm(np.diff(self.points, axis=0, prepend=self.points[:1]), axis=1)
        new_line = np.diff(self.labels, prepend=-1) != 0
        # On a large picture places are spaced wider than a px: see MOST_PLACES.
        spacing = max(1.0, round(float(np.median(steps)), 1)) if len(steps) else 1.0
        gap = steps > GAP * spacing
        return np.asarray(new_line | (np.diff(self.sides, prepend=0) != 0) | gap)

    def from_crossings(self) -> Floats:
        """How far (n,) px points are, along their lines, from where the bright side changes; else inf."""
        steps = np.linalg.norm(np.diff(self.points, axis=0, prepend=self.points[:1]), axis=1)
        same_line = np.diff(self.labels, prepend=-1) == 0
        after = np.flatnonzero(same_line & (np.diff(self.sides, prepend=0) != 0))
        along = np.cumsum(steps)
        at, line = (along[after] + along[after - 1]) / 2, self.labels[after]
        away = np.full(len(along), np.inf)
        for nearest in (-1, 0) if len(at) else ():
            i = np.clip(np.searchsorted(at, along) + nearest, 0, len(at) - 1)
            away = np.minimum(away, np.where(line[i] == self.labels, np.abs(along - at[i]), np.inf))
        return away

    def thinned(self, most: int) -> Measured:
        """Return every second, third, … point, so that about ``most`` remain.

        A line of which no more remain than what is fitted to it would tell nothing, and is left out. Where
        that leaves out most lines, there are too many of them to be thinned.
        """
        step = len(self.points) // most
        if step < 2:
            return self
        chosen = np.arange(len(self.points)) % step == 0
        remaining = np.bincount(self.labels[chosen], minlength=int(self.labels.max()) + 1)
        telling = remaining > FITTED_TO_A_LINE
        return self.take(chosen & telling[self.labels]) if telling.mean() > 0.5 else self


def smoothed(grey: Grey, size: float = SMOOTHING) -> Grey:
    """The picture that ``measure`` samples, smoothed by ``size`` px (sigma)."""
    return np.asarray(cv2.GaussianBlur(grey, (0, 0), size, borderType=cv2.BORDER_REPLICATE))


def measure(
    smooth: Grey,
    points: Floats,
    labels: Labels,
    params: Floats,
    follow: bool = False,
    steps: bool = False,
) -> Measured:
    """Measure the lines through ``points`` (n, 2) with ``labels`` (n,) again, one profile a pixel.

    An edge is the steepest place near where ``params`` (lam, cx, cy[, lam2]) says that a line runs; with
    ``follow``, near where its points run, if they are known to a pixel; with ``steps``, too, it is a step
    fitted there: noise moves that less, but it looks at more of what lies around.
    """
    along = courses(points, labels, params, follow)
    if len(along.at) == 0:
        return Measured.none()
    reach = WIDEST if steps else BESIDE
    offsets = np.arange(-reach, reach + 1, dtype=np.float64)
    seen = sample_smoothly(smooth, along.at[:, None] + offsets[:, None] * along.normals[:, None])
    levels = _average_along(seen, along.owner)
    edges = fit_steps(levels, along.owner) if steps else _steepest(levels)
    strength = np.abs(edges.heights)
    usual = usual_of(strength, along.owner, int(labels.max()) + 1)
    good = edges.near & (strength > LEAST_STRENGTH * usual[along.owner])
    good &= _inside(along, edges.reach, smooth)
    ends = np.sort(levels[good][:, [reach - BESIDE, reach + BESIDE]], axis=1)
    white = np.full(len(ends), np.median(ends[:, 1]) if len(ends) else 0.0)
    points = along.at[good] + edges.offsets[good, None] * along.normals[good]
    sides = np.sign(edges.heights[good])
    # The steeper an edge, the less noise moves it.
    told = strength[good] ** 2
    return Measured(points, along.owner[good], sides, np.column_stack([ends, white]), told)


def _steepest(levels: Floats) -> Steps:
    """The steepest places of profiles, and their slopes."""
    across = (levels[:, 2:] - levels[:, :-2]) / 2
    index, rows = np.abs(across).argmax(axis=1), np.arange(len(across))
    near = (index > 0) & (index < 2 * REACH)
    index = np.clip(index, 1, 2 * REACH - 1)
    peak, before, after = across[rows, index], across[rows, index - 1], across[rows, index + 1]
    top = before - 2 * peak + after
    shift = (before - after) / 2 / np.where(np.abs(top) < 1e-6, 1e-6, top)
    offsets = index - REACH + np.clip(shift, -0.75, 0.75)
    return Steps(offsets, peak, near, np.full(len(rows), REACH + 1))


def _inside(along: Courses, looked: Labels, smooth: Grey) -> NDArray[np.bool_]:
    """Which places lie so far inside the picture that all of their profile does."""
    h, w = smooth.shape
    reach = looked[:, None] * np.abs(along.normals)
    return np.asarray(
        ((along.at >= reach) & (along.at <= np.array([w - 1, h - 1]) - reach)).all(axis=1)
    )


def usual_of(values: Floats, owner: Labels, count: int) -> Floats:
    """The upper quartile of each owner's values, 0 for one that has none: a row of bars has many gaps."""
    return np.array(
        [np.quantile(values[owner == i], USUAL) if np.any(owner == i) else 0 for i in range(count)]
    )


def _average_along(across: NDArray[np.floating], owner: Labels) -> Floats:
    """Average each profile with its neighbours on the same line."""
    half = NEIGHBORS // 2
    total = across.astype(np.float64)
    number = np.ones((len(across), 1))
    for step in range(1, half + 1):
        same = (owner[step:] == owner[:-step])[:, None]
        total[step:] += np.where(same, across[:-step], 0)
        total[:-step] += np.where(same, across[step:], 0)
        number[step:] += same
        number[:-step] += same
    return total / number
