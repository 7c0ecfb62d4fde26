"""The plumb-line fit: the model under which grouped points are straightest (Brown 1971; Devernay 2001)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.sparse import csr_array

from ..straightness import LEAST_DENOMINATOR, Floats, Labels, OnLines, PointsOnLines

# How far bright areas may seem to grow, px by unit of a column: one standard deviation of what is believed
# beforehand.
GROWTH_SPREAD = 0.5
# Profiles are averaged, and neighbours err alike: about so many points in a row tell as much as one alone.
# What is believed beforehand weighs beside residuals as one standard deviation of theirs, half a softness.
ALIKE = 6
PULL = 0.5 * np.sqrt(ALIKE)
# Lambda times the squared reach of the points stays within these: beyond, the points would lie past the fold.
LAMBDA_RANGE = (-3.0, 2.0)
# The step that slopes by the model's parameters are told by, in units of the solver's variables.
STEP = np.sqrt(np.finfo(np.float64).eps)
# A residual beyond so many standard deviations, of so many px at least, is none of its line's.
OUTLYING, LEAST_SIGMA = 5.0, 0.02


@dataclass(frozen=True)
class Prior:
    """What is believed of the distortion centre before any line is seen: (x, y) and its spread, px.

    A spread of 0 keeps the centre where it is.
    """

    center: tuple[float, float]
    spread: tuple[float, float]

    @property
    def fixed(self) -> bool:
        """Whether the centre is given rather than sought."""
        return max(self.spread) == 0


@dataclass(frozen=True)
class Places:
    """Where lines run beside a grid: ``residuals`` (q,) and ``jacobian`` (q, k + g), as those of a Fit.

    ``pulls`` (q, m): by how much px a place moves as the points of its line, every ``step``-th of the Fit's,
    go to the left by a px, but for what the grids follow of it: ``followed`` (q, r), orthonormal.
    """

    residuals: Floats
    jacobian: Floats
    pulls: csr_array
    step: int
    followed: Floats

    def moved(self, left: Floats) -> Floats:
        """How the residuals move, (q, c), as those points go to the left by ``left`` (m, c) px."""
        pulled = np.asarray(self.pulls @ left)
        return np.asarray(pulled - self.followed @ (self.followed.T @ pulled))


@dataclass(frozen=True)
class Fit:
    """A fit of (lam, cx, cy[, lam2]).

    ``residuals`` (m,) px; ``jacobian`` (m, k + g): theirs by the parameters that were free, whose places in
    the vector are ``free``, k of them, and by the columns of growth. ``belief`` (k + g,): what was believed
    beforehand adds so much to the sum of squares, px^2, for a unit that they are off, squared; one standard
    deviation adds ``pull`` px, squared. ``growth`` (g,): how much of each; ``sigma`` px: the robust standard
    deviation; ``softness`` px, ``trust`` (m,): see fit_model. ``points`` (m, 2) px: whose residuals they are,
    and ``scale`` (m,) how many px of residual a corrected px makes, where that is not as the picture has it.
    ``places``: where that told the model, too, how lines run beside a grid.
    """

    params: Floats
    residuals: Floats
    jacobian: Floats
    free: list[int]
    belief: Floats
    pull: float
    growth: Floats
    sigma: float
    softness: float
    trust: Floats
    points: Floats
    scale: Floats | None = None
    places: Places | None = None


def robust_sigma(values: Floats) -> float:
    """The standard deviation of the bulk of ``values``, from their median size."""
    return float(np.median(np.abs(values))) / 0.6745


def inlying(residuals: Floats, sigma: float) -> NDArray[np.bool_]:
    """Which ``residuals`` (m,) px are those of points that follow their lines, and err by ``sigma`` px."""
    return np.asarray(np.abs(residuals) < OUTLYING * max(sigma, LEAST_SIGMA))


def fit_model(
    points: Floats,
    labels: Labels,
    start: Floats,
    radius: float,
    prior: Prior,
    softness: float,
    sides: Floats | None = None,
    growth: Floats | None = None,
    rounds: int = 30,
    monotonic: float = 0.0,
    trust: Floats | None = None,
    held: bool = False,
) -> Fit:
    """Fit (lam, cx, cy[, lam2]) to points (n, 2) with line labels (n,), starting at ``start``.

    ``radius`` px is the length by which the parameters are scaled; residuals beyond ``softness`` px count
    ever less (Cauchy). With ``sides``, how far bright areas grow is fitted too: see ``residuals`` for lines
    seen from both sides; and whatever combination of ``growth``, columns (n, g) px, goes with all lines.
    The two-parameter model is kept from folding within ``monotonic`` px of the centre. ``trust`` (n,), 1 in
    the mean, weighs the points. With ``held`` the model stays as it is, and growth alone is fitted.
    """
    trust = np.ones(len(points)) if trust is None else trust
    columns = np.empty((len(points), 0)) if growth is None else growth
    free = [i for i in range(len(start)) if not (held or (prior.fixed and i in (1, 2)))]
    unit = np.array([radius**-2, 0.1 * radius, 0.1 * radius, radius**-4])[free]
    root, pull = np.sqrt(trust), softness * PULL
    first = PointsOnLines(points, labels, trust, sides).under(start).residuals()
    weights = trust / (1 + trust * (first / softness) ** 2)
    lines = PointsOnLines(points, labels, weights, sides)

    def params(x: Floats) -> Floats:
        out = start.copy()
        out[free] += x[: len(free)] * unit
        if len(out) > 3 and monotonic > 0:
            out[3] = np.clip(out[3], *second_range(out[0], monotonic))
        return out

    # The solver asks for slopes where it has just asked for residuals.
    @lru_cache(maxsize=1)
    def seen(*params: float) -> OnLines:
        return lines.under(np.array(params))

    def residuals(x: Floats) -> Floats:
        return seen(*params(x)).residuals(columns @ x[len(free) :])

    def slopes(x: Floats) -> Floats:
        here, by_growth = residuals(x), seen(*params(x)).by_growth(columns)
        steps = STEP * np.where(x < 0, -1.0, 1.0) * np.maximum(np.abs(x), 1.0)
        ways = np.diag(steps)[: len(free)]
        by_model = [(residuals(x + way) - here) / way.sum() for way in ways]
        return np.concatenate([np.reshape(by_model, (-1, len(here))).T, by_growth], axis=1)

    units = np.append(unit, np.ones(columns.shape[1]))
    spread = [np.inf, *prior.spread, np.inf]
    spreads = np.append(np.array(spread)[free], np.full(columns.shape[1], GROWTH_SPREAD)) / units
    believed = np.zeros(len(units))
    believed[: len(free)] = (np.array([0.0, *prior.center, 0.0])[: len(start)] - start)[free] / unit

    def loss(z: Floats) -> Floats:
        """Cauchy's for residuals, squares for beliefs: a far one counts in full."""
        n = len(points)
        rho = np.stack([z, np.ones_like(z), np.zeros_like(z)])
        weight = 1 / (1 + z[:n])
        rho[:, :n] = np.log1p(z[:n]), weight, -(weight**2)
        return rho

    x = np.zeros(len(units))
    if len(x):
        x = least_squares(
            lambda x: np.append(root * residuals(x), pull * (x - believed) / spreads),
            x,
            jac=lambda x: np.concatenate([root[:, None] * slopes(x), np.diag(pull / spreads)]),
            method="trf",
            loss=loss,
            f_scale=softness,
            x_scale="jac",
            bounds=_bounds(start[free] / unit, len(x)),
            xtol=1e-7,
            ftol=1e-9,
            max_nfev=rounds,
        ).x
    r = residuals(x)
    belief = (pull / (spreads * units)) ** 2
    grown, sigma = x[len(free) :], robust_sigma(r)
    plain = slopes(x) / units
    return Fit(params(x), r, plain, free, belief, pull, grown, sigma, softness, trust, points)


def _bounds(start: Floats, count: int) -> tuple[Floats, Floats]:
    """Bounds of the solver's variables, steps in units from ``start``: those of lambda."""
    low, high = np.full(count, -np.inf), np.full(count, np.inf)
    if len(start) == 0:
        return low, high
    low[0], high[0] = LAMBDA_RANGE[0] - start[0], LAMBDA_RANGE[1] - start[0]
    return np.minimum(low, -1e-3), np.maximum(high, 1e-3)


def folds(params: Floats, radius: float) -> bool:
    """Whether the two-parameter model, if it is one, folds within ``radius`` px."""
    if len(params) < 4 or radius <= 0:
        return False
    low, high = second_range(params[0], radius)
    return not low <= params[3] <= high


def second_range(lam: float, radius: float) -> tuple[float, float]:
    """The range of lam2 in which 1 + lam q + lam2 q^2 and 1 - lam q - 3 lam2 q^2 stay above 0.

    That is, in which the map is positive and monotonic for q up to ``radius`` squared, with
    ``LEAST_DENOMINATOR`` to spare.
    """
    q = (radius * np.linspace(0.1, 1, 64)) ** 2
    low = (LEAST_DENOMINATOR - 1 - lam * q) / q**2
    high = (1 - LEAST_DENOMINATOR - lam * q) / (3 * q**2)
    return float(low.max()), float(high.min())
