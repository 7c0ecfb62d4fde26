"""Points near the corner where an edge ends, put back on the edge.

Blur rounds a corner. At a right angle that makes the edge weak there, and leaves it in its place; at a slant
it draws the steepest place off the edge, by up to the width of the blur, and opposite ways at the two ends of
a bar's end. How far follows from the angle of the two edges that meet, and the blur: see ``drawn_off``.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree
from scipy.special import ndtr

from ..straightness import Floats, Lines, Undistorted, fit_lines
from .profiles import AVERAGED, Measured

# Where the points of an edge end, the line that cuts it off crosses within so many widths of the last one,
# and was itself measured within so many px and widths of the corner: widths times the cotangent of their
# angle, where that is more, since a wedge so much thinner is blurred as much farther from its tip.
AT_END, SEEN_NEAR, SEEN_WIDTHS = 3.0, 4.0, 2.0
# Nearly all of what was measured of it lies to one side of the edge: so many more than to the other.
ONE_SIDE = 0.6
# The cotangent of the angle between them is at most this: what crosses at less is not told so well where.
MOST_SLANT = 6.0
# Steepest places are sought so far to both sides of an edge, in widths, in such steps.
ASIDE, STEP = 1.6, 0.05
# Farther than so many widths from a corner, in the same way, nothing is drawn off.
FARTHEST = 5.0
# What is drawn off by more than so many px is left out.
MOST_OFF = 0.4


@dataclass(frozen=True)
class _Corner:
    """Where another line cuts an edge off.

    ``place`` (2,) px; ``tangent`` (2,) into the edge, ``normal`` (2,) across it; the other line runs along
    tangent times ``slant`` plus normal, and its edge is on the ``side`` of the normal, +1, or the other, -1.
    """

    place: Floats
    tangent: Floats
    normal: Floats
    slant: float
    side: float


def on_their_edges(lines: Measured, widths: Floats, params: Floats) -> Measured:
    """Return the points with what corners draw them off taken away, without those that are drawn off far.

    ``widths`` (count,) px: of each line's blurred step, its standard deviation as it was sampled.
    """
    if len(lines.points) == 0:
        return lines
    course = _Course.of(lines, params)
    off, clear = np.zeros(len(lines.points)), np.ones(len(lines.points), bool)
    for first, last in _edges(lines):
        width = float(widths[lines.labels[first]])
        wide = float(np.hypot(width, np.sqrt(AVERAGED)))
        for end, inner in ((first, min(first + 2, last)), (last, max(last - 2, first))):
            corner = course.corner(end, inner, wide)
            if corner is None:
                continue
            x = (course.points[first : last + 1] - corner.place) @ corner.tangent / wide
            near = first + np.flatnonzero(x < FARTHEST * max(1.0, abs(corner.slant)))
            slant = -corner.side * corner.slant * width / wide
            drawn = -corner.side * width * drawn_off(x[near - first], slant)
            off[near] -= drawn * np.sign(course.across[near] @ corner.normal)
            clear[near] &= np.abs(drawn) < MOST_OFF
    moved = lines.points + off[:, None] * course.across
    return replace(lines, points=moved).take(clear)


@dataclass(frozen=True)
class _Course:
    """Where lines run: ``points`` (n, 2) px on them beside those measured, unit normals ``across`` (n, 2)."""

    measured: Measured
    params: Floats
    fitted: Lines
    points: Floats
    across: Floats
    tree: cKDTree

    @classmethod
    def of(cls, lines: Measured, params: Floats) -> _Course:
        """Fit the lines under a model, and drop their points onto them."""
        under = Undistorted.of(lines.points, params)
        count = int(lines.labels.max()) + 1
        fitted = fit_lines(under.u, lines.labels, count, under.denominator**2)
        normals = fitted.normals[lines.labels]
        pulled = under.pulled_back(normals)
        scale = np.linalg.norm(pulled, axis=1)
        across = pulled / scale[:, None]
        beside = np.einsum("ij,ij->i", normals, under.u) - fitted.offsets[lines.labels]
        points = lines.points - (beside / scale)[:, None] * across
        return cls(lines, params, fitted, points, across, cKDTree(lines.points))

    def corner(self, end: int, inner: int, wide: float) -> _Corner | None:
        """The corner where an edge ends at point number ``end``; number ``inner`` is another of its points.

        ``wide`` px: the blur of the edge along itself. None where no line is seen to cut it off.
        """
        if inner == end:
            return None
        normal = self.across[end]
        tangent = np.array([normal[1], -normal[0]])
        tangent *= np.sign(tangent @ (self.points[inner] - self.points[end]))
        count = len(self.fitted.offsets)
        here = Undistorted.of(np.repeat(self.points[end : end + 1], count, axis=0), self.params)
        slopes = here.pulled_back(self.fitted.normals)
        away = self.fitted.offsets - np.einsum("ij,ij->i", self.fitted.normals, here.u)
        # How far along the edge, px, each line crosses it; it never does where the slope is zero.
        along = slopes @ tangent
        along[np.abs(along) < 1e-9] = 1e-9
        at, slant = away / along, -(slopes @ normal) / along
        reach = wide * np.maximum(np.abs(slant), 1)
        near = (np.abs(at) < AT_END * reach) & (np.abs(slant) < MOST_SLANT)
        near[self.measured.labels[end]] = False
        if not near.any():
            return None
        other = np.flatnonzero(near)[np.abs(at[near]).argmin()]
        place = self.points[end] + at[other] * tangent
        around = self.tree.query_ball_point(place, SEEN_NEAR + SEEN_WIDTHS * reach[other])
        seen = np.array([i for i in around if self.measured.labels[i] == other], np.intp)
        side = np.sign((self.measured.points[seen] - place) @ normal).sum()
        if abs(side) <= ONE_SIDE * len(seen):
            return None
        return _Corner(place, tangent, normal, float(slant[other]), float(np.sign(side)))


def _edges(lines: Measured) -> list[tuple[int, int]]:
    """The first and last index of the points of each edge: where a line has none for a while, one ends."""
    first = np.flatnonzero(lines.edge_starts())
    last = np.append(first[1:], len(lines.points)) - 1
    return list(zip(first.tolist(), last.tolist(), strict=True))


def drawn_off(x: Floats, slant: float) -> Floats:
    """Where an edge, y = 0 from x = 0 on, seems to be near a corner: y at the places ``x`` (n,) along it.

    Between the edge and the line x = ``slant`` y lies a wedge, all of it where y < 0, blurred by 1. Its slope
    along y is, but for the sign, f(y) F(x) + c / k f((x - c y) / k) F(-(y + c x) / k) with k^2 = 1 + c^2 for
    c = ``slant``, f and F being the normal density and its integral.
    """
    y = np.arange(-ASIDE, ASIDE + STEP / 2, STEP)[:, None]
    k = np.hypot(1, slant)
    steep = _density(y) * ndtr(x) + slant / k * _density((x - slant * y) / k) * ndtr(
        -(y + slant * x) / k
    )
    top = np.clip(np.abs(steep).argmax(axis=0), 1, len(y) - 2)
    before, at, after = (np.abs(steep)[top + i, np.arange(len(x))] for i in (-1, 0, 1))
    bend = np.minimum(before - 2 * at + after, -1e-12)
    return np.asarray(y[top, 0] + STEP * np.clip((before - after) / 2 / bend, -1, 1))


def _density(x: Floats) -> Floats:
    return np.asarray(np.exp(-0.5 * x**2) / np.sqrt(2 * np.pi))
