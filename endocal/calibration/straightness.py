"""How far points that belong on straight lines are from them, under a model.

A parameter vector is (lam, cx, cy) or (lam, cx, cy, lam2); lines are labels 0 … n-1, one per point. All
in square pixels. Line fits are eliminated (variable projection): a residual depends on the model alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Labels = NDArray[np.intp]
Chosen = NDArray[np.bool_]

# The denominator of the model is kept above this where points near the fold are tried.
LEAST_DENOMINATOR = 0.02


@dataclass(frozen=True)
class Undistorted:
    """Points under a model, as offsets from its centre, px: before (d), after (u), and squared radii."""

    d: Floats
    u: Floats
    q: Floats
    denominator: Floats
    slope: Floats  # derivative of the denominator by q

    @classmethod
    def of(cls, points: Floats, params: Floats) -> Undistorted:
        """Undistort (n, 2) points by ``params``; past the fold the denominator is held at its least."""
        lam2 = params[3] if len(params) > 3 else 0.0
        # Columns that lie together: all that follows takes x and y apart.
        d = np.asfortranarray(points) - params[1:3]
        q = np.einsum("ij,ij->i", d, d)
        denominator = 1 + q * (params[0] + q * lam2)
        slope = np.where(denominator > LEAST_DENOMINATOR, params[0] + 2 * q * lam2, 0.0)
        denominator = np.maximum(denominator, LEAST_DENOMINATOR)
        return cls(d, d / denominator[:, None], q, denominator, slope)

    def scale(self, normals: Floats) -> Floats:
        """Undistorted px per distorted px, along the undistorted ``normals`` (n, 2)."""
        return np.hypot(*self.pulled_back(normals).T)

    def pulled_back(self, normals: Floats) -> Floats:
        """The transposed Jacobian applied to undistorted normals (n, 2): those in the distorted picture."""
        along = np.einsum("ij,ij->i", normals, self.d)
        pull = 2 * self.slope * along / self.denominator**2
        return normals / self.denominator[:, None] - pull[:, None] * self.d

    def gradients(self, gradients: Floats) -> Floats:
        """Unit gradients at the undistorted points (eq. 7), from gradients (n, 2) at the distorted."""
        gx, gy = gradients.T
        dx, dy = self.d.T
        a = -2 * self.slope * (dy * gx - dx * gy)
        out = np.stack([a * dy + gx * self.denominator, gy * self.denominator - a * dx], axis=1)
        return out / np.maximum(np.linalg.norm(out, axis=1), 1e-300)[:, None]


@dataclass(frozen=True)
class Lines:
    """Straight lines fitted to undistorted points: normals (n, 2), offsets (n,), relative to the centre."""

    normals: Floats
    offsets: Floats


def root_mean_square(values: Floats) -> float:
    """Return the root mean square of ``values``, 0 of none."""
    return float(np.sqrt(np.mean(values**2))) if len(values) else 0.0


def fit_lines(u: Floats, labels: Labels, count: int, weights: Floats) -> Lines:
    """Fit each line by weighted total least squares to its undistorted points (m, 2)."""
    return fit_lines_by(u, labels, weights, Totals(labels, count))


def fit_lines_by(u: Floats, labels: Labels, weights: Floats, total: Totals) -> Lines:
    """Fit lines as ``fit_lines`` does, with sums over their points that are at hand."""
    x, y = np.ascontiguousarray(u.T)
    mass = np.maximum(total(weights), 1e-300)
    mx, my = total(weights * x) / mass, total(weights * y) / mass
    ex, ey = x - mx.take(labels), y - my.take(labels)
    wx = weights * ex
    sxx, syy, sxy = total(wx * ex), total(weights * ey * ey), total(wx * ey)
    angle = 0.5 * np.arctan2(2 * sxy, sxx - syy)
    nx, ny = -np.sin(angle), np.cos(angle)
    return Lines(np.stack([nx, ny]).T, nx * mx + ny * my)


def residuals(
    points: Floats,
    labels: Labels,
    params: Floats,
    weights: Floats | None = None,
    sides: Floats | None = None,
    growth: Floats | None = None,
) -> Floats:
    """Return each point's signed distance (m,) to its line, in px.

    It is measured in the distorted picture, where the noise of edges is the same everywhere: a model that
    shrinks the corrected picture gains nothing. ``weights`` (m,) are those of the line fits.

    ``sides`` (m,), +1 or -1, tells on which side of its line a point is bright: over-exposure and gamma
    make bright squares grow, so a line seen from both sides has two edges some way apart. That distance
    is fitted for each line along with its place and direction. ``growth`` (m,) px, to the left as the points
    of a line go, is taken off as given; for it the points must come line after line.
    """
    return PointsOnLines(points, labels, weights, sides).under(params).residuals(growth)


class PointsOnLines:
    """Points of which each belongs to a line, to be seen under one model after the other.

    Arguments are those of ``residuals``.
    """

    def __init__(
        self,
        points: Floats,
        labels: Labels,
        weights: Floats | None = None,
        sides: Floats | None = None,
    ) -> None:
        self._points, self._labels = np.asfortranarray(points), labels
        self._weights = np.ones(len(points)) if weights is None else weights
        self._two_sided = None if sides is None else two_sided(sides, labels)
        self._total = Totals(labels, int(labels.max()) + 1)

    def under(self, params: Floats) -> OnLines:
        """Fit a line to the points of each under ``params``, and see the points from there."""
        labels, total = self._labels, self._total
        at = Undistorted.of(self._points, params)
        lines = fit_lines_by(at.u, labels, self._weights * at.denominator**2, total)
        normals = lines.normals.T.take(labels, axis=1).T
        scale = at.scale(normals)
        distance = (np.einsum("ij,ij->i", normals, at.u) - lines.offsets.take(labels)) / scale
        columns = [1 / scale, (normals[:, 1] * at.u[:, 0] - normals[:, 0] * at.u[:, 1]) / scale]
        if self._two_sided is not None:
            columns.append(self._two_sided)
        own = _Eliminated.of(columns, labels, total, self._weights)
        return OnLines(at, normals, distance, own)


@dataclass(frozen=True)
class OnLines:
    """Points (m, 2) under a model, seen from the lines fitted to them; see ``residuals``.

    ``normals`` (m, 2): those of their lines; ``distance`` (m,) px in the distorted picture; ``own``: what is
    fitted to each line apart.
    """

    at: Undistorted
    normals: Floats
    distance: Floats
    own: _Eliminated

    @cached_property
    def left(self) -> Floats:
        """Signs (m,): +1 where the normal is to the left of the way that the points of the line go.

        For it the points must come line after line.
        """
        labels = self.own.labels
        firsts = np.searchsorted(labels, np.arange(self.own.total.count))
        return leftward(self.at.d, labels, self.normals[firsts])[labels]

    def residuals(self, growth: Floats | None = None) -> Floats:
        """How far (m,) px the points are from their lines; ``growth`` (m,) px as in ``residuals``."""
        off = self.distance
        if growth is not None and growth.any():
            off = off - growth * self.left
        return self.own.without(off)

    def by_growth(self, columns: Floats) -> Floats:
        """The derivatives (m, g) of the residuals by how much there is of growths, ``columns`` (m, g) px."""
        if columns.shape[1] == 0:
            return columns
        grown = -self.left * columns.T
        return np.stack([self.own.without(column) for column in grown], axis=1)


def leftward(points: Floats, labels: Labels, normals: Floats) -> Floats:
    """Signs (count,) of the lines' ``normals``: +1 to the left of the way from a line's first point to its
    last.

    The normal of a fitted line turns round as the line turns past a certain direction; its points do not.
    """
    starts = np.searchsorted(labels, np.arange(len(normals) + 1))
    wx, wy = (points[starts[1:] - 1] - points[starts[:-1]]).T
    return np.where(normals[:, 1] * wx - normals[:, 0] * wy >= 0, 1.0, -1.0)


def two_sided(sides: Floats, labels: Labels) -> Floats:
    """``sides``, but 0 on lines that show hardly more than one: there it could not be told from bending."""
    share = np.bincount(labels, sides > 0) / np.maximum(np.bincount(labels), 1)
    return np.where(np.abs(share - 0.5) < 0.4, 1.0, 0.0)[labels] * sides


@dataclass(frozen=True)
class _Eliminated:
    """Columns, k of (m,), that are fitted to values on each line apart, by points of these ``weights`` (m,).

    ``inverse`` (count, k, k): that of the lines' normal equations.
    """

    columns: Sequence[Floats]
    weighted: Sequence[Floats]
    inverse: Floats
    labels: Labels
    total: Totals

    @classmethod
    def of(
        cls, columns: Sequence[Floats], labels: Labels, total: Totals, weights: Floats
    ) -> _Eliminated:
        k = len(columns)
        weighted = [weights * column for column in columns]
        normal = np.empty((total.count, k, k))
        for i in range(k):
            for j in range(i + 1):
                normal[:, i, j] = normal[:, j, i] = total(weighted[i] * columns[j])
        # A column of zeros, or a line of one point, takes nothing away.
        diagonal = np.einsum("lii->li", normal)
        diagonal += 1e-9 * diagonal + 1e-12
        inverse = np.asarray(np.linalg.inv(normal), np.float64)
        return cls(columns, weighted, inverse, labels, total)

    def without(self, values: Floats) -> Floats:
        """What is left of ``values`` (m,) once the columns are fitted to it."""
        right = np.stack([self.total(column * values) for column in self.weighted], axis=1)
        fitted = np.einsum("lij,lj->li", self.inverse, right)
        for i, column in enumerate(self.columns):
            values = values - column * fitted[:, i].take(self.labels)
        return values


class Totals:
    """Sums over the points of each line: called with values (m,), returns (count,).

    Where the labels come in order, as they do in fits, that is several times as fast as a bincount.
    """

    def __init__(self, labels: Labels, count: int) -> None:
        self._labels = labels
        self.count = count
        self._in_order = not np.any(labels[1:] < labels[:-1])
        if self._in_order:
            starts = np.searchsorted(labels, np.arange(count))
            self._there = np.diff(starts, append=len(labels)) > 0
            self._starts = starts[self._there]

    def __call__(self, values: Floats) -> Floats:
        """Return the sums (count,) of ``values`` (m,)."""
        if not self._in_order:
            return np.asarray(np.bincount(self._labels, values, self.count), np.float64)
        out = np.zeros(self.count)
        out[self._there] = np.add.reduceat(values, self._starts)
        return out
