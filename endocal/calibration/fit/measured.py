"""The final fit: lines measured on profiles, told from what is no board, and fitted, in rounds.

All coordinates are in square pixels. The views of a lens share its model, and keep their lines apart.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..board.pattern import clear_of_crossings, join_pieces, measured_once, on_board
from ..measure.growth import growth_columns
from ..measure.profiles import Measured
from ..straightness import Floats, Labels, residuals
from .grid_fit import fit_grid
from .misfit import Misfit, misfit, trust_by_magnification
from .plumb_line import ALIKE, Fit, Prior, fit_model, folds, robust_sigma
from .uncertainty import covariance
from .view import View, measured_again, measured_in, with_end_rows

# Lines that a fit needs at least.
FEWEST_LINES = 3
# The rounds: the first measures where the model says that lines run, others where they were measured. A
# third one is for lines that the second joined from pieces.
MOST_ROUNDS = 3
# A fit that is not the last does with so many points: neighbours on a line tell much the same.
ENOUGH_POINTS = 4000
# Where averages along lines are noisier than this, px, noise is worse than what else a fitted step looks at.
NOISY = 0.05
# A lens departs from the model where its lines stay bent by more than this share of the noise; then so many
# rounds find the weights of its points, and a residual is an outlier so many times later.
MODEL_HOLDS = 1.0
INFORMED_ROUNDS = 2
CORRECTED_ROUNDS = 2
CORRECTED_SOFTNESS = 2.0
# The softness of a last fit, px, at least.
LEAST_SOFTNESS = 0.05
# Residuals beyond this many softnesses of the fit are none of its lines'.
OUTLYING = 3.0


@dataclass(frozen=True)
class Refined:
    """A fit with the measured points it rests on.

    ``view`` (n,) tells which view each point is from; ``boards`` the views in which a chessboard was seen;
    ``corners``, where they rather than the points told the model, the fit to them and its residuals' lines
    (m,).
    """

    fit: Fit
    measured: Measured
    view: Labels
    boards: frozenset[int]
    corners: tuple[Fit, Labels] | None = None

    @property
    def board(self) -> bool:
        """Whether a chessboard was seen in any view."""
        return bool(self.boards)

    @property
    def covariance(self) -> Floats:
        """The covariance (k, k) of the model's parameters, by what told them; zeros for a given centre."""
        fit, labels = self.corners or (self.fit, self.measured.labels)
        full = np.zeros((len(fit.params), len(fit.params)))
        full[np.ix_(fit.free, fit.free)] = covariance(fit, labels)
        return full


def fit_measured(
    views: Sequence[View],
    lines: Sequence[tuple[Floats, Labels]],
    params: Floats,
    sigma: float,
    reach: float,
    prior: Prior,
    content: float,
) -> Refined | None:
    """Measure the lines of each view, points (n, 2) and labels (n,), and fit the model to all of them.

    ``params`` and ``sigma`` px: the model that found the lines, and its residual. None with too few lines.
    """
    measured = [measured_in(v, *line, params) for v, line in zip(views, lines, strict=True)]
    for number in range(MOST_ROUNDS):
        whole = [join_pieces(part) for part in measured]
        boards = [on_board(part) for part in whole]
        parts = [
            part.take(measured_once(part) if board is None else board)
            for part, board in zip(whole, boards, strict=True)
        ]
        clear = [part.take(clear_of_crossings(part)) for part in parts]
        everything, view_of = _joined([part.take(telling(part)) for part in clear])
        if len(everything.points) == 0 or everything.labels.max() + 1 < FEWEST_LINES:
            return None
        few = everything.thinned(ENOUGH_POINTS)
        fit = _fit(few, params, reach, prior, max(0.1, sigma), content)
        params, sigma = fit.params, fit.sigma
        if number == 0:
            noisy = _noise(everything, fit) > NOISY
            if not any(board is not None for board in boards):
                parts = [
                    with_end_rows(v, part, params) for v, part in zip(views, parts, strict=True)
                ]
        elif all(a is b for a, b in zip(measured, whole, strict=True)):
            break
        if number < MOST_ROUNDS - 1:
            measured = [
                measured_again(view, part, params, board is not None, noisy)
                for view, part, board in zip(views, parts, boards, strict=True)
            ]
    fit = _fit(everything, params, reach, prior, _softness(sigma), content)
    on_boards = frozenset(number for number, board in enumerate(boards) if board is not None)
    refined = Refined(fit, everything, view_of, on_boards)
    if refined.board:
        return refined
    return replace(refined, fit=_weighted(everything, fit, reach, prior, content))


def telling(measured: Measured) -> NDArray[np.bool_]:
    """Which points (n,) are on lines of more points than a single one tells as much as.

    A line with no more points than what is fitted to it is straight under any model; of what rounding leaves
    of its residuals, slopes are differences.
    """
    return (np.bincount(measured.labels) > ALIKE)[measured.labels]


def _noise(m: Measured, fit: Fit) -> float:
    off = residuals(m.points, m.labels, fit.params, sides=m.sides)
    return misfit(off, m.labels, OUTLYING * fit.softness).noise


def departure_from_model(fit: Fit, labels: Labels) -> Misfit:
    """How far lines, labels (n,) of the fit's points, stay bent, and how noisy they are."""
    return misfit(fit.residuals, labels, OUTLYING * fit.softness)


def departs(refined: Refined) -> bool:
    """Whether a board's lines stay bent by more than noise explains: the lens is none of the model's.

    Without a board's crossings to hold them to, a model with more freedom finds lines in anything.
    """
    ratio = departure_from_model(refined.fit, refined.measured.labels).ratio
    return refined.board and ratio >= MODEL_HOLDS


def fit_again(
    refined: Refined, start: Floats, reach: float, prior: Prior, content: float
) -> Refined:
    """Fit another model, from ``start``, to lines that are measured already."""
    # That fit's softness is that of another model.
    few = fit_to_few(refined, start, reach, prior, content)
    fit = _fit(refined.measured, few.params, reach, prior, _softness(few.sigma), content)
    return replace(refined, fit=fit)


def fit_to_few(refined: Refined, start: Floats, reach: float, prior: Prior, content: float) -> Fit:
    """Fit another model, from ``start``, to as many of the measured points as tell roughly what it is."""
    few = refined.measured.thinned(ENOUGH_POINTS)
    return _fit(few, start, reach, prior, _softness(refined.fit.sigma), content)


def _softness(sigma: float) -> float:
    """The softness of a fit whose residuals are known to lie within ``sigma`` px or so."""
    return max(LEAST_SOFTNESS, 2 * sigma)


def told_by_corners(
    refined: Refined, corners: tuple[Fit, Labels], reach: float, prior: Prior, content: float
) -> Refined:
    """Take the model from a fit to ``corners``, and see what the measured points leave under it."""
    fit = refined.fit
    params = corners[0].params
    seen = _fit(refined.measured, params, reach, prior, fit.softness, content, held=True)
    return replace(refined, fit=seen, corners=corners)


def told_by_grid(refined: Refined, reach: float, content: float) -> Refined:
    """Take the model that makes a board's lines those of a regular grid, too, where they have places in it.

    A lens that departs from the model moves lines off any grid.
    """
    if departure_from_model(refined.fit, refined.measured.labels).ratio >= MODEL_HOLDS:
        return refined
    fit = fit_grid(refined.measured, refined.view, refined.fit, reach)
    if fit is None or folds(fit.params, content):
        return refined
    return replace(refined, fit=fit)


def magnified(refined: Refined, reach: float, prior: Prior, content: float) -> Refined:
    """Fit the measured points again with weights that make straight what the corrected picture magnifies."""
    return replace(refined, fit=_magnified(refined.measured, refined.fit, reach, prior, content))


def _weighted(m: Measured, fit: Fit, reach: float, prior: Prior, content: float) -> Fit:
    """Fit lines of no board again: by magnification where the lens departs, else by what each point tells.

    The edges of a board are alike; other straight things are edges of all kinds.
    """
    if departure_from_model(fit, m.labels).ratio >= MODEL_HOLDS:
        return _magnified(m, fit, reach, prior, content)
    trust = m.information / m.information.mean()
    for _ in range(INFORMED_ROUNDS):
        softness = _softness(robust_sigma(np.sqrt(trust) * fit.residuals))
        fit = _fit(m, fit.params, reach, prior, softness, content, trust)
    return fit


def _magnified(m: Measured, fit: Fit, reach: float, prior: Prior, content: float) -> Fit:
    """Fit points again with weights that make straight what the corrected picture magnifies."""
    ratio = departure_from_model(fit, m.labels).ratio
    softness = CORRECTED_SOFTNESS * fit.softness
    for part in (m.thinned(ENOUGH_POINTS),) * CORRECTED_ROUNDS + (m,):
        trust = trust_by_magnification(part.points, part.labels, fit.params, ratio)
        fit = _fit(part, fit.params, reach, prior, softness, content, trust)
    return fit


def _fit(
    m: Measured,
    start: Floats,
    reach: float,
    prior: Prior,
    softness: float,
    content: float,
    trust: Floats | None = None,
    held: bool = False,
) -> Fit:
    growth = growth_columns(m.sides, m.levels, m.labels)
    return fit_model(
        m.points,
        m.labels,
        start,
        reach,
        prior,
        softness,
        m.sides,
        growth,
        monotonic=content,
        trust=trust,
        held=held,
    )


def fit_alone(
    refined: Refined, chosen: NDArray[np.bool_], reach: float, prior: Prior, content: float
) -> tuple[Fit, Measured]:
    """Fit a model to some of the measured points alone, and return these, too."""
    fit, part = refined.fit, refined.measured.take(chosen)
    return _fit(part, fit.params, reach, prior, fit.softness, content), part


def _joined(parts: Sequence[Measured]) -> tuple[Measured, Labels]:
    count = 0
    labels = []
    for part in parts:
        labels.append(part.labels + count)
        count += int(part.labels.max()) + 1 if len(part.labels) else 0
    joined = Measured.joined(parts, np.concatenate(labels))
    return joined, np.repeat(np.arange(len(parts)), [len(p.points) for p in parts])
