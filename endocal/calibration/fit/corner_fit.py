"""The fit for a lens that departs from the model: straight rows and columns in the *corrected* picture.

No model of the kind is right there, and which one is best depends on what is made small. This takes what one
sees: how far the corners of a board lie from straight lines in the corrected picture, measured by the mean
side of its squares there, so that a model gains nothing by shrinking the picture.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from ..board.lifted import Corners
from ..straightness import LEAST_DENOMINATOR, Floats, Labels, root_mean_square
from .plumb_line import LEAST_SIGMA, Fit, Prior, robust_sigma

# A row or column counts from so many corners on, and boards with at least so many of both in all.
FEWEST_CORNERS = 3
FEWEST_ROWS = 6
# So far off its row or column, as a share of the mean square, no corner lies that was numbered rightly.
MOST_ASTRAY = 0.25
# Nor does the farthest lie so many robust standard deviations off: of real lenses it is 11 at most, and 33
# where a line was measured along something else.
MOST_OUTLYING = 15.0
# A fit to corners explains more than chance does from this on: so many times the corners' own variance, for
# each parameter. Chance does so once in a hundred times.
SIGNIFICANT = 4.0
# The solver is run again where it made the residual less than this share of what it was, at most so often.
SETTLED = 0.99
MOST_ROUNDS = 6
STEPS = 100


@dataclass(frozen=True)
class _Rows:
    """The rows and columns of boards: each corner once in each.

    ``corners`` (n, 2) px of all boards; ``index`` (m,) into them, ``line`` (m,) the number of the row or
    column, ``neighbors`` (k, 2) pairs of corners next to each other, ``board`` (k,) whose; ``board_of`` (m,).
    """

    corners: Floats
    index: Labels
    line: Labels
    neighbors: Labels
    board: Labels
    board_of: Labels
    boards: int

    @classmethod
    def of(cls, boards: Sequence[Corners]) -> _Rows:
        """Sort the corners of boards into rows and columns."""
        index, line, neighbors, board, board_of = [], [], [], [], []
        first = count = 0
        for number, corners in enumerate(boards):
            for axis in (0, 1):
                for value in np.unique(corners.places[:, axis]):
                    own = np.flatnonzero(corners.places[:, axis] == value)
                    if len(own) < FEWEST_CORNERS:
                        continue
                    own = own[np.argsort(corners.places[own, 1 - axis])]
                    next_to = np.diff(corners.places[own, 1 - axis]) == 1
                    neighbors.append(first + np.stack([own[:-1], own[1:]], axis=1)[next_to])
                    board.append(np.full(len(neighbors[-1]), number))
                    index.append(first + own)
                    line.append(np.full(len(own), count))
                    board_of.append(np.full(len(own), number))
                    count += 1
            first += len(corners.points)
        return cls(
            corners=np.concatenate([b.points for b in boards]),
            index=_all(index),
            line=_all(line),
            neighbors=np.concatenate([np.empty((0, 2), np.intp), *neighbors]),
            board=_all(board),
            board_of=_all(board_of),
            boards=len(boards),
        )

    @property
    def lines(self) -> Labels:
        """How many rows and columns each board has."""
        first = np.flatnonzero(np.diff(self.line, prepend=-1))
        return np.bincount(self.board_of[first], minlength=self.boards)

    def pull(self, rms: float) -> float:
        """How much, px, one standard deviation of a belief weighs: a line's residuals of ``rms`` px each."""
        return float(rms * np.sqrt(len(self.line) / self.lines.sum()))

    def off(self, params: Floats) -> Floats:
        """Return how far each corner lies from its row or column (m,), corrected, then scaled back, px."""
        d = self.corners - params[1:3]
        u = d / self._denominator(d, params)
        u = u[self.index] * self._scale(u)[self.board_of, None]
        counts = np.bincount(self.line)
        x, y = (v - (np.bincount(self.line, v) / counts)[self.line] for v in u.T)
        sxx, syy, sxy = (np.bincount(self.line, v) for v in (x * x, y * y, x * y))
        turn = (0.5 * np.arctan2(2 * sxy, sxx - syy))[self.line]
        return np.asarray(y * np.cos(turn) - x * np.sin(turn))

    def astray(self, params: Floats) -> float:
        """How far, in mean squares of its board, a corner lies from its row or column at most."""
        spacing = self._spacing(self.corners)[self.board_of]
        return float(np.max(np.abs(self.off(params)) / spacing))

    def scale(self, params: Floats) -> Floats:
        """By how much corrected lengths are scaled back, (m,)."""
        d = self.corners - params[1:3]
        return self._scale(d / self._denominator(d, params))[self.board_of]

    def _scale(self, u: Floats) -> Floats:
        return self._spacing(self.corners) / self._spacing(u)

    @staticmethod
    def _denominator(d: Floats, params: Floats) -> Floats:
        q = np.einsum("ij,ij->i", d, d)
        lam2 = params[3] if len(params) > 3 else 0.0
        return np.maximum(1 + q * (params[0] + q * lam2), 1e-3)[:, None]

    def _spacing(self, corners: Floats) -> Floats:
        """The mean distance of neighbours on each board."""
        ends = corners[self.neighbors]
        away = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        count = np.bincount(self.board, minlength=self.boards)
        return np.bincount(self.board, away, self.boards) / np.maximum(count, 1)


def _all(parts: Sequence[Labels]) -> Labels:
    return np.concatenate([np.empty(0, np.intp), *parts])


def fit_corners(
    boards: Sequence[Corners], start: Floats, prior: Prior, monotonic: float
) -> tuple[Fit, Labels] | None:
    """Fit (lam, cx, cy[, lam2]) from ``start`` downhill; return the fit and its residuals' lines (m,).

    No corner is sent farther out than 1 / LEAST_DENOMINATOR, 50 times as far as it is seen, which an
    equidistant lens does 89 degrees off its axis: nearer to the pole of the model one corner can be sent so
    far out that all other distances shrink to nothing beside it.
    ``boards``: those of all views, in square px. The prior weighs as much as one line's evidence. The
    two-parameter model is kept from folding within ``monotonic`` px, too.
    None where a board shows too few rows and columns, or one that a corner lies far off, by the size of
    squares or of what others are off: it is another's.
    """
    rows = _Rows.of(boards)
    if rows.lines.min() < FEWEST_ROWS or rows.astray(start) > MOST_ASTRAY:
        return None
    params, rms = start, root_mean_square(rows.off(start))
    # Where the farthest corner becomes another one the bound has a kink, and steps end early.
    for _ in range(MOST_ROUNDS):
        params = _downhill(rows, params, prior, monotonic, rms)
        before, rms = rms, root_mean_square(rows.off(params))
        if rms > SETTLED * before:
            break
    fit = _as_fit(rows, params, prior)
    if np.abs(fit.residuals).max() > MOST_OUTLYING * max(fit.sigma, LEAST_SIGMA):
        return None
    return fit, rows.line


def tell_apart(boards: Sequence[Corners], corners: tuple[Fit, Labels], before: Floats) -> bool:
    """Whether corners tell the fit to them from parameters ``before``: one leaves more, beyond noise.

    Corners that are few or poor are made straighter by chance. Noise changes from one corner of a row to the
    next, and what the lens bends beside the model does not. The fit leaves more than ``before`` does where
    that sends corners farther out than it may.
    """
    fit, lines = corners
    off = fit.residuals
    same_row = lines[2:] == lines[:-2]
    # One corner less its neighbours' mean: 1 + 1/4 + 1/4 times the noise's variance.
    jumps = (off[1:-1] - (off[:-2] + off[2:]) / 2)[same_row] / np.sqrt(1.5)
    gain = abs(float(np.sum(_Rows.of(boards).off(before) ** 2) - np.sum(off**2)))
    return gain > SIGNIFICANT * len(fit.free) * root_mean_square(jumps) ** 2


def fit_corners_from_one(
    boards: Sequence[Corners], start: Floats, prior: Prior, monotonic: float
) -> tuple[Fit, Labels] | None:
    """Fit (lam, cx, cy, lam2) from where the one-parameter fit from ``start`` (lam, cx, cy) ends.

    It may end in another valley than ``fit_corners`` does. For what else is given and returned, see there.
    """
    one = fit_corners(boards, start, prior, 0.0)
    if one is None:
        return None
    return fit_corners(boards, np.append(one[0].params, 0.0), prior, monotonic)


def _downhill(rows: _Rows, start: Floats, prior: Prior, monotonic: float, rms: float) -> Floats:
    """One run of the solver; ``rms`` px: what residuals are expected to be, for the weight of the prior."""
    second = len(start) > 3

    def outermost(center: Floats) -> float:
        """How far, px, from this centre the model must hold."""
        farthest = float(np.sqrt(np.max(np.sum((rows.corners - center) ** 2, axis=1))))
        return max(farthest, monotonic)

    # What lam and lam2 together bend there, and lam2's part of it, in units of the most, so that the bound is
    # a number.
    most = LEAST_DENOMINATOR - 1
    unit = 0.1 * outermost(start[1:3])

    def params(x: Floats) -> Floats:
        center = start[1:3] if prior.fixed else start[1:3] + unit * x[1:3]
        q = outermost(center) ** 2
        bend = most * x[0]
        if not second:
            return np.array([bend / q, *center])
        part = np.clip(most * x[-1], *_part_range(bend))
        return np.array([(bend - part) / q, *center, part / q**2])

    x = np.zeros(1 + (0 if prior.fixed else 2) + second)
    high = np.full(len(x), np.inf)
    q = outermost(start[1:3]) ** 2
    if second:
        x[-1] = start[3] * q**2 / most
    x[0], high[0] = min((start[0] * q / most) + (x[-1] if second else 0.0), 1 - 1e-4), 1.0
    pull = rows.pull(rms)

    def misfit(x: Floats) -> Floats:
        at = params(x)
        beliefs = np.empty(0) if prior.fixed else (at[1:3] - prior.center) / np.array(prior.spread)
        return np.concatenate([rows.off(at), pull * beliefs])

    low = np.full(len(x), -np.inf)
    return params(least_squares(misfit, x, bounds=(low, high), x_scale="jac", max_nfev=STEPS).x)


def _part_range(bend: float) -> tuple[float, float]:
    """The range of lam2 q^2, if lam q + lam2 q^2 is ``bend``, in which the map is sound for radii up to q.

    That is, positive and monotonic, with ``LEAST_DENOMINATOR`` to spare, at shares t of q.
    """
    t = np.linspace(0.1, 0.99, 64) ** 2
    positive = (1 - LEAST_DENOMINATOR + bend * t) / (t - t * t)
    slope, room = 3 * t * t - t, 1 - LEAST_DENOMINATOR - bend * t
    high = min(positive.min(), (room / slope)[slope > 0].min())
    return float((room / slope)[slope < 0].max()), float(high)


def _as_fit(rows: _Rows, params: Floats, prior: Prior) -> Fit:
    """The residuals at ``params`` and their derivatives, none of which counts less than another."""
    radius = float(np.sqrt(np.max(np.sum((rows.corners - params[1:3]) ** 2, axis=1))))
    step = 1e-5 * np.array([radius**-2, radius, radius, radius**-4])[: len(params)]
    free = [i for i in range(len(params)) if not (prior.fixed and i in (1, 2))]
    slopes = []
    for i in free:
        moved = np.zeros(len(params))
        moved[i] = step[i]
        slopes.append((rows.off(params + moved) - rows.off(params - moved)) / (2 * step[i]))
    off = rows.off(params)
    jacobian = np.stack(slopes, axis=1)
    pull = rows.pull(root_mean_square(off))
    belief = (pull / np.array([np.inf, *prior.spread, np.inf])[free]) ** 2
    ones = np.ones(len(off))
    return Fit(
        params,
        off,
        jacobian,
        free,
        belief,
        pull,
        np.empty(0),
        robust_sigma(off),
        np.inf,
        ones,
        rows.corners[rows.index],
        rows.scale(params),
    )
