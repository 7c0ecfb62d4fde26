"""What moves all lines of a picture together: a smooth field of displacements, told from what a fit leaves.

A board that is creased or bowed, a lens that departs from the model, what is left of light and sampling: each
moves all points smoothly over the picture. Part of that looks like another lens, and the fit takes it; the
rest stays, and tells how strong the field is, and so how far the fit may be off.
The field is a vector polynomial of the place in the picture, with random coefficients. Those of a degree have
one variance, which falls from each degree to the next by a factor.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solve_triangular

from ..straightness import Floats, Labels, Undistorted, fit_lines, leftward
from .plumb_line import Fit
from .waves import Waves

# The degrees of the field. One that is linear keeps the lines straight, or nearly.
LOWEST, HIGHEST = 2, 5
# By what the variance of a coefficient may fall from one degree to the next; and how strong, px, one of the
# lowest degree may be, one standard deviation, with so many steps between: all are as likely beforehand. The
# odds that there is a field at all: low enough that where there is none next to nothing is added.
FALLS = (1.0, 1 / 3, 1 / 10)
WEAKEST, STRONGEST, STEPS = 1e-5, 10.0, 60
ODDS = 0.05
# What lines see of the field by less than this share of what they see best tells nothing: what is there may
# be of a degree beyond the highest.
WELL_SEEN = 0.1
# The least variance of a wave, px^2, as of a line's noise: there may be none at all.
LEAST_POWER = 1e-12
# So many slow waves for each unknown tell the field from noise.
ENOUGH = 1.5


@dataclass(frozen=True)
class SharedField:
    """The K modes of a field, each of 1 px in the mean square, as the m points of a fit see them.

    ``modes`` (m, K / 2): those of a displacement in x, and once more in y. ``across`` (m, 2): how far a point
    moves across its line, to the left, px by px. ``stretch`` (m,): by how much more its residual moves, and
    with what sign. ``place``, ``turn`` (m,): how a line's own place and direction move residuals, orthogonal
    under ``weights`` (m,). ``starts`` (l,): where lines begin, ``line`` (m,) their numbers.
    """

    modes: Floats
    across: Floats
    stretch: Floats
    place: Floats
    turn: Floats
    weights: Floats
    starts: Labels
    line: Labels

    @classmethod
    def seen_by(cls, fit: Fit, labels: Labels) -> SharedField:
        """See a field as the residuals of a fit do, those of lines ``labels`` (m,), line after line."""
        at = Undistorted.of(fit.points, fit.params)
        weights = fit.trust / (1 + fit.trust * (fit.residuals / fit.softness) ** 2)
        by_length = weights * at.denominator**2 if fit.scale is None else weights
        lines = fit_lines(at.u, labels, int(labels.max()) + 1, by_length)
        normals = lines.normals[labels]
        local = 1 / at.scale(normals)
        signs = leftward(fit.points, labels, lines.normals)[labels]
        across = at.pulled_back(normals) * (signs * local)[:, None]
        place = local if fit.scale is None else fit.scale
        starts = np.flatnonzero(np.diff(labels, prepend=-1))
        line = np.cumsum(np.diff(labels, prepend=-1) != 0) - 1
        along = place * (normals[:, 1] * at.u[:, 0] - normals[:, 0] * at.u[:, 1])
        both = np.add.reduceat(weights * along * place, starts)
        turn = along - place * (both / np.add.reduceat(weights * place**2, starts))[line]
        modes = _modes(fit.points)
        return cls(modes, across, signs * place / local, place, turn, weights, starts, line)

    def residuals(self) -> Floats:
        """How far residuals move by each mode, (m, K), beside what their lines' own places follow."""
        moved = self._moved(self.across * self.stretch[:, None])
        for column in (self.place, self.turn):
            weighted = self.weights * column
            size = np.maximum(np.add.reduceat(weighted * column, self.starts), 1e-12)
            part = np.add.reduceat(weighted[:, None] * moved, self.starts, axis=0)
            moved -= column[:, None] * (part / size[:, None])[self.line]
        return moved

    def leftward(self, step: int) -> Floats:
        """How far every ``step``-th point moves to the left along its line by each mode, (n, K)."""
        return replace(self, modes=self.modes[::step])._moved(self.across[::step])

    def _moved(self, across: Floats) -> Floats:
        count = self.modes.shape[1]
        moved = np.empty((len(across), 2 * count))
        np.multiply(across[:, :1], self.modes, out=moved[:, :count])
        np.multiply(across[:, 1:], self.modes, out=moved[:, count:])
        return moved


def mode_variances(waves: Waves, moved: Floats, left: Floats) -> Floats:
    """The variance (K,), px^2, of each mode of a field; 0 where nothing tells of one.

    ``waves``: what a fit left, and how much of each, ``left`` (n,); ``moved`` (s, K): of those that are
    ``slow`` the part that each mode makes.
    """
    each = np.arange(LOWEST, HIGHEST + 1)
    degree = np.tile(np.repeat(each, each + 1), 2)
    slow = waves.slow
    taken = np.hstack([waves.slopes[slow], moved])
    if len(taken) < ENOUGH * taken.shape[1]:
        return np.zeros(len(degree))
    # The noise beside any field: told from what is left when all that a field could be is taken off.
    root = np.sqrt(waves.noise()[slow])
    basis = _basis(taken / root[:, None])
    apart, left = waves.heights.copy(), left.copy()
    level = waves.heights[slow] / root
    apart[slow] = root * (level - basis @ (basis.T @ level))
    left[slow] = 1 - np.sum(basis**2, axis=1)
    root = np.sqrt(np.maximum(waves.power(apart, left)[slow], LEAST_POWER))
    # What the parameters take of the field tells nothing of it.
    basis = _basis(waves.slopes[slow] / root[:, None])
    heights, seen = waves.heights[slow] / root, moved / root[:, None]
    seen = seen - basis @ (basis.T @ seen)
    sizes, ways = np.linalg.eigh(seen.T @ seen)
    well = sizes > WELL_SEEN**2 * sizes[-1]
    sizes, ways = np.sqrt(sizes[well]), ways[:, well]
    # Each of these is of a variance of 1, and what the field adds.
    told = (ways.T @ (seen.T @ heights)) / sizes
    return _expected(told, sizes[:, None] * ways.T, degree)


def _expected(told: Floats, seen: Floats, degree: Labels) -> Floats:
    """The variance (K,) expected of each mode, given ``told`` (q,): noise of variance 1, and the field.

    ``seen`` (q, K): how the modes, each of its ``degree``, move what is told.
    """
    variances = np.exp(np.linspace(np.log(WEAKEST), np.log(STRONGEST), STEPS)) ** 2
    shares, likely = [], []
    for fall in FALLS:
        share = fall ** (degree - LOWEST)
        powers, ways = np.linalg.eigh((seen * share) @ seen.T)
        total = 1 + variances[:, None] * np.maximum(powers, 0.0)
        squares = (ways.T @ told) ** 2
        # Relative to there being no field.
        likely.append(0.5 * np.sum(squares - squares / total - np.log(total), axis=1))
        shares.append(share)
    most = max(0.0, float(np.max(likely)))
    weights = ODDS * np.exp(np.array(likely) - most) / (STEPS * len(FALLS))
    return np.asarray((weights @ variances) @ np.array(shares) / (weights.sum() + np.exp(-most)))


def _basis(columns: Floats) -> Floats:
    """An orthonormal basis (n, r) of what ``columns`` (n, c) span."""
    size = np.linalg.norm(columns, axis=0)
    basis, sizes, _ = np.linalg.svd(columns / np.where(size > 0, size, 1.0), full_matrices=False)
    return np.asarray(basis[:, sizes > 1e-6 * sizes[0]])


def _modes(points: Floats) -> Floats:
    """Polynomials in the places of points (m, 2), (m, K / 2), of a root mean square of 1, degree by degree.

    Orthogonal over the points to each other and to all of lower degree.
    """
    middle = points.mean(axis=0)
    x, y = ((points - middle) / np.abs(points - middle).max()).T
    powers = [np.ones((1, len(points)))]
    for _ in range(HIGHEST):
        powers.append(np.vstack([powers[-1] * x, powers[-1][-1:] * y]))
    every = np.concatenate(powers)
    # Twice: once leaves a trace where points lie in few places.
    for _ in range(2):
        root = np.linalg.cholesky(every @ every.T / len(points) + 1e-12 * np.eye(len(every)))
        every = solve_triangular(root, every, lower=True)
    return np.ascontiguousarray(every[LOWEST * (LOWEST + 1) // 2 :].T)
