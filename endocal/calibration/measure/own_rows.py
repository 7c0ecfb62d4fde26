"""Edges that run nearly level in one field of an interlaced picture, measured on the rows that it has.

A field has every second row. Of a sharp picture that is too few: between two rows an edge may lie anywhere,
and the grey levels interpolated there put it halfway. Along an edge that is nearly level the steepest place
then waves to and fro, by up to half a px, as rows come and go under it, over as many px as the edge takes to
cross from row to row. The pixels of the field's own rows are at known distances from the edge, though, and
those along one such wave see its step at every distance: a step is fitted to them as they are.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from ..image.picture import Grey
from ..straightness import Floats, Labels, residuals
from .courses import normals_of
from .profiles import LEAST_STRENGTH, Measured, usual_of

# Nearly level is an edge whose normal is so near to the vertical (a cosine). Others cross a row in so few px
# that the smoothing of profiles evens out what waves.
LEVEL = 0.9
# Rows of a field are so many px apart.
APART = 2
# Widths (standard deviations of the blur) that are tried, px. Edges of the last one, or wider, lose nothing
# between rows.
WIDTHS = np.arange(0.3, 0.95, 0.1)
# A step is looked at so many px to both sides, and sought up to so far from its course, in such steps, px.
REACH, FARTHEST, SPACING = 3.0, 0.8, 0.1
SHIFTS = np.arange(-FARTHEST, FARTHEST + SPACING / 2, SPACING)
# So many columns to both sides are looked at with each, at least and at most. Between two rows a wide step
# passes for a sharp one elsewhere: to tell the width it takes all of a wave.
FEWEST, MOST, MOST_FOR_WIDTH = 2, 12, 100
# At the ends of an edge so many columns are a corner's.
CORNER = 1
# A line runs smoothly: as its points do, but for a polynomial of this degree.
SMOOTH = 3
# What ``matched`` calls information is that of a px of edge in a full picture but for a factor; and it leaves
# out what taking differences and sampling smooth: points on sharp edges tell so many times more than it says.
LEFT_OUT = 1.4
UNIT = LEFT_OUT * 8 * np.sqrt(np.pi) / 3 / APART


def on_own_rows(grey: Grey, first: int, lines: Measured, params: Floats) -> Measured:
    """Return ``lines`` with the points of nearly level edges measured on rows ``first``, ``first`` + 2, ...

    ``grey`` (h, w): a field, its other rows interpolated; ``params``: the model under which the lines run.
    What those rows do not tell is left out. Pictures soft enough to lose nothing come back as they are.
    """
    if len(lines.points) == 0:
        return lines
    across = normals_of(lines.points, lines.labels, lines.points, lines.labels, params)
    chosen = np.abs(across[:, 1]) > LEVEL
    if not chosen.any():
        return lines
    course = _smooth_course(lines, across, params)[chosen]
    edges = np.cumsum(lines.edge_starts(), dtype=np.intp)[chosen]
    pixels = _Pixels.near(grey, first, course, across[chosen])
    width = _width(pixels, _Windows.of(edges, across[chosen], MOST_FOR_WIDTH))
    if width == WIDTHS[-1]:
        return lines
    windows = _Windows.of(edges, across[chosen], MOST)
    offsets, told = _fitted(pixels, windows, width)
    points, information = lines.points.copy(), lines.information.copy()
    points[chosen] = course + offsets[:, None] * across[chosen]
    # A px of edge crosses so many columns.
    information[chosen] = told * np.abs(across[chosen, 1]) / UNIT
    owner = lines.labels[chosen]
    usual = usual_of(told, owner, int(owner.max()) + 1)[owner]
    kept = np.ones(len(points), bool)
    kept[chosen] = (told > LEAST_STRENGTH**2 * usual) & (np.abs(offsets) < FARTHEST - SPACING)
    return replace(lines, points=points, information=information).take(kept)


def _smooth_course(lines: Measured, across: Floats, params: Floats) -> Floats:
    """The points (n, 2) px put onto the smooth course of their edge."""
    off = residuals(lines.points, lines.labels, params, sides=lines.sides)
    smooth = np.empty_like(off)
    for label in np.unique(lines.labels):
        own = lines.labels == label
        t = np.linspace(-1, 1, np.count_nonzero(own))
        smooth[own] = np.polynomial.Polynomial.fit(t, off[own], min(SMOOTH, len(t) - 1))(t)
    return lines.points - (off - smooth)[:, None] * across


@dataclass(frozen=True)
class _Pixels:
    """Pixels of a field's own rows in the columns of places: ``away`` (n, k) px from the edge, ``levels``.

    ``seen`` (n, k): which are in the picture and near enough.
    """

    away: Floats
    levels: Floats
    seen: NDArray[np.bool_]

    @classmethod
    def near(cls, grey: Grey, first: int, course: Floats, across: Floats) -> _Pixels:
        """Take the pixels near places ``course`` (n, 2) px, by their distances along ``across`` (n, 2)."""
        h, w = grey.shape
        column = np.clip(np.rint(course[:, 0]).astype(np.intp), 0, w - 1)
        to_column = (column - course[:, 0]) * across[:, 0]
        middle = first + APART * np.rint((course[:, 1] - first) / APART).astype(np.intp)
        steps = int(np.ceil(REACH / APART))
        rows = middle[:, None] + APART * np.arange(-steps, steps + 1)
        away = (rows - course[:, 1:]) * across[:, 1:] + to_column[:, None]
        seen = (rows >= 0) & (rows < h) & (np.abs(away) < REACH)
        levels = grey[np.clip(rows, first, h - 1), column[:, None]].astype(np.float64)
        return cls(away, levels, seen)


@dataclass(frozen=True)
class _Windows:
    """Neighbouring places on an edge that are looked at together: from index ``start`` to ``end`` (n,)."""

    start: Labels
    end: Labels

    @classmethod
    def of(cls, edges: Labels, across: Floats, most: int) -> _Windows:
        """So many on the same one of ``edges`` (n,) that it crosses from row to row, where they can.

        To each side no more than ``most``.
        """
        here = np.arange(len(edges))
        begins = np.flatnonzero(np.diff(edges, prepend=-1))
        length = np.diff(begins, append=len(edges))
        corner = np.minimum(CORNER, (length - 1) // 2)
        low, high = (np.repeat(x, length) for x in (begins + corner, begins + length - corner))
        wave = APART * np.abs(across[:, 1]) / np.maximum(np.abs(across[:, 0]), 1e-9)
        half = np.clip(np.rint(wave / 2), FEWEST, most).astype(np.intp)
        start = np.clip(here - half, low, high - 1)
        return cls(start, np.clip(here + half + 1, start + 1, high))

    def sums(self, values: Floats) -> Floats:
        """Sums over windows of ``values`` (n, ...)."""
        total = np.concatenate([np.zeros((1, *values.shape[1:])), np.cumsum(values, axis=0)])
        return np.asarray(total[self.end] - total[self.start])


def _fitted(pixels: _Pixels, windows: _Windows, width: float) -> tuple[Floats, Floats]:
    """Fit a step of this width to each window: offsets (n,) px from the course, and what they are told by.

    The second, (n,), is the inverse of the variance that white noise of one grey level gives an offset, for
    each column of the window.
    """
    left = _left(pixels, windows, width, SHIFTS)
    rows, k = np.arange(len(left)), np.clip(left.argmin(axis=1), 1, len(SHIFTS) - 2)
    before, at, after = (left[rows, k + i] for i in (-1, 0, 1))
    bend = np.maximum(before - 2 * at + after, 1e-9)
    offsets = SHIFTS[k] + SPACING * np.clip((before - after) / 2 / bend, -1, 1)
    # Squares grow by the information times the square of how far a step is off.
    return offsets, bend / 2 / SPACING**2 / (windows.end - windows.start)


def _width(pixels: _Pixels, windows: _Windows) -> float:
    """The one of WIDTHS at which steps leave least of the squares of all windows."""
    width = float(np.median(WIDTHS))
    for _ in WIDTHS:
        # Steps of a wrong width lie at places that suit it: they are sought again with each.
        offsets, _ = _fitted(pixels, windows, width)
        there = replace(pixels, away=pixels.away - offsets[:, None])
        left = [_left(there, windows, other, np.zeros(1)).sum() for other in WIDTHS]
        before, width = width, float(WIDTHS[np.argmin(left)])
        if width == before:
            break
    return width


def _left(pixels: _Pixels, windows: _Windows, width: float, shifts: Floats) -> Floats:
    """What steps at ``shifts`` (s,) px, of any height, leave of the squares of each window: (n, s)."""
    seen = pixels.seen.astype(np.float64)
    y = pixels.levels * seen
    count, sy, syy = (windows.sums(x.sum(axis=1)) for x in (seen, y, y * y))
    rise = ndtr((pixels.away[:, :, None] - shifts) / width) * seen[:, :, None]
    sr, srr = windows.sums(rise.sum(axis=1)), windows.sums(np.einsum("nks,nks->ns", rise, rise))
    sry = windows.sums(np.einsum("nk,nks->ns", y, rise))
    count = np.maximum(count, 1.0)[:, None]
    both = sry - sr * sy[:, None] / count
    explained = both**2 / np.maximum(srr - sr**2 / count, 1e-9)
    return np.asarray(syy[:, None] - sy[:, None] ** 2 / count - explained)
