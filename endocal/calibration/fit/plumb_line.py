"""The plumb-line fit: the model under which grouped points are straightest (Brown 1971; Devernay 2001)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache, partial

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
    ``rounds``: how many models the solver looks at, at most.
    """
    trust = np.ones(len(points)) if trust is None else trust
    columns = np.empty((len(points), 0)) if growth is None else growth
    free = [i for i in range(len(start)) if not (held or (prior.fixed and i in (1, 2)))]
    first = PointsOnLines(points, labels, trust, sides).under(start).residuals()
    weights = trust / (1 + trust * (first / softness) ** 2)
    lines = PointsOnLines(points, labels, weights, sides)
    unit = np.array([radius**-2, 0.1 * radius, 0.1 * radius, radius**-4])[free]
    steps = _Steps(lines, start, free, unit, columns, monotonic)

    root, pull = np.sqrt(trust), softness * PULL
    units = np.append(unit, np.ones(columns.shape[1]))
    believed, spreads = _beliefs(prior, start, free, units)
    x = np.zeros(len(units))
    if len(x):
        x = least_squares(
            lambda x: np.append(root * steps.residuals(x), pull * (x - believed) / spreads),
            x,
            jac=lambda x: np.concatenate(
                [root[:, None] * steps.slopes(x), np.diag(pull / spreads)]
            ),
            method="trf",
            loss=partial(_cauchy_then_squares, len(points)),
            f_scale=softness,
            x_scale="jac",
            bounds=_bounds(start[free] / unit, len(x)),
            xtol=1e-7,
            ftol=1e-9,
            max_nfev=rounds,
        ).x
    r = steps.residuals(x)
    belief = (pull / (spreads * units)) ** 2
    grown, sigma = x[len(free) :], robust_sigma(r)
    plain = steps.slopes(x) / units
    return Fit(steps.params(x), r, plain, free, belief, pull, grown, sigma, softness, trust, points)


class _Steps:
    """What the solver varies (k,), see ``fit_model``, and what the points make of it.

    Steps from ``start``, in units ``unit`` of the ``free`` parameters, then how much there is of each growth.
    """

    def __init__(
        self,
        lines: PointsOnLines,
        start: Floats,
        free: list[int],
        unit: Floats,
        columns: Floats,
        monotonic: float,
    ) -> None:
        self._start, self._free, self._unit = start, free, unit
        self._columns, self._monotonic = columns, monotonic
        # The solver asks for slopes where it has just asked for residuals.
        self._under = lru_cache(maxsize=1)(lambda *params: lines.under(np.array(params)))

    def params(self, x: Floats) -> Floats:
        """The model's parameters (lam, cx, cy[, lam2])."""
        out = self._start.copy()
        out[self._free] += x[: len(self._free)] * self._unit
        if len(out) > 3 and self._monotonic > 0:
            out[3] = np.clip(out[3], *second_range(out[0], self._monotonic))
        return out

    def residuals(self, x: Floats) -> Floats:
        """Those of the points (m,), px."""
        return self._seen(x).residuals(self._columns @ x[len(self._free) :])

    def slopes(self, x: Floats) -> Floats:
        """The derivatives (m, k) of the residuals: by the model's parameters differences, by growth exact."""
        here, by_growth = self.residuals(x), self._seen(x).by_growth(self._columns)
        steps = STEP * np.where(x < 0, -1.0, 1.0) * np.maximum(np.abs(x), 1.0)
        ways = np.diag(steps)[: len(self._free)]
        by_model = [(self.residuals(x + way) - here) / way.sum() for way in ways]
        return np.concatenate([np.reshape(by_model, (-1, len(here))).T, by_growth], axis=1)

    def _seen(self, x: Floats) -> OnLines:
        return self._under(*self.params(x))


def _beliefs(prior: Prior, start: Floats, free: list[int], units: Floats) -> tuple[Floats, Floats]:
    """What the solver's variables (k,) are believed to be, and the standard deviations (k,) of that."""
    count = len(free)
    spread = np.array([np.inf, *prior.spread, np.inf])[free]
    spreads = np.append(spread, np.full(len(units) - count, GROWTH_SPREAD)) / units
    middle = np.array([0.0, *prior.center, 0.0])[: len(start)]
    believed = np.zeros(len(units))
    believed[:count] = (middle - start)[free] / units[:count]
    return believed, spreads


def _cauchy_then_squares(count: int, z: Floats) -> Floats:
    """The loss of ``count`` residuals, and of beliefs after them: a far one of these counts in full."""
    rho = np.stack([z, np.ones_like(z), np.zeros_like(z)])
    weight = 1 / (1 + z[:count])
    rho[:, :count] = np.log1p(z[:count]), weight, -(weight**2)
    return rho


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
