"""How far points that belong on straight lines are from them, under a model.

A parameter vector is (lam, cx, cy) or (lam, cx, cy, lam2); lines are labels 0 … n-1, one per point. All
in square pixels. Line fits are eliminated (variable projection): a residual depends on the model alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Labels = NDArray[np.intp]

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
        denominator = np.maximum(1 + q * (params[0] + q * lam2), LEAST_DENOMINATOR)
        return cls(d, d / denominator[:, None], q, denominator, params[0] + 2 * q * lam2)

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
    count = int(labels.max()) + 1
    weights = np.ones(len(points)) if weights is None else weights
    at = Undistorted.of(points, params)
    total = Totals(labels, count)
    first = fit_lines_by(at.u, labels, weights * at.denominator**2, total)
    normals = first.normals.T.take(labels, axis=1).T
    scale = at.scale(normals)
    distance = (np.einsum("ij,ij->i", normals, at.u) - first.offsets.take(labels)) / scale
    if growth is not None:
        distance = distance - growth * leftward(points, labels, first.normals)[labels]
    along = (normals[:, 1] * at.u[:, 0] - normals[:, 0] * at.u[:, 1]) / scale
    columns = [1 / scale, along]
    if sides is not None:
        columns.append(two_sided(sides, labels))
    return _without(distance, columns, labels, total, weights)


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


def _without(
    values: Floats, columns: Sequence[Floats], labels: Labels, total: Totals, weights: Floats
) -> Floats:
    """What is left of ``values`` (m,) when ``columns``, k of (m,), are fitted to it on each line apart."""
    k = len(columns)
    normal = np.empty((total.count, k, k))
    right = np.empty((total.count, k))
    for i, column in enumerate(columns):
        weighted = weights * column
        right[:, i] = total(weighted * values)
        for j in range(i + 1):
            normal[:, i, j] = normal[:, j, i] = total(weighted * columns[j])
    # A column of zeros, or a line of one point, takes nothing away.
    diagonal = np.einsum("lii->li", normal)
    diagonal += 1e-9 * diagonal + 1e-12
    fitted = np.linalg.solve(normal, right[..., None])[..., 0]
    for i, column in enumerate(columns):
        values = values - column * fitted[:, i].take(labels)
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
