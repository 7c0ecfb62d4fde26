"""How sure a fit is: the covariance of its parameters, by how its residuals are correlated.

Two things make errors that are not each point's own. What an edge is measured by is shared by its neighbours:
``waves`` tells the spectrum of that, by which each line errs apart from the others. And what bends all lines
together is a smooth field over the picture: ``shared_field`` tells how strong that is.
"""

from __future__ import annotations

import numpy as np

from ...model import DivisionModel
from ..straightness import Floats, Labels
from .plumb_line import Fit
from .shared_field import SharedField, mode_variances
from .waves import Waves

# The model's fold this near to the outermost points, as a share of their radius.
NEAR_FOLD = 1.02


def covariance(fit: Fit, labels: Labels) -> Floats:
    """The covariance (k, k) of the free parameters of a fit to points with line labels (n,), line after line.

    The sandwich estimator of a robust fit, with the residuals' spectrum in the middle, and what the
    parameters take of a field that all lines share. What is not known of the growth counts, and what is
    believed beforehand as the fit weighs it. Of a fit that ended at lambda's bound, what was believed.
    """
    if at_bound(fit):
        return _believed(fit)
    root = np.sqrt(fit.trust)
    # A parameter held at a bound moves nothing: its column is zero, and so is its variance. Growth that
    # moves next to nothing is known by what was believed of it, and must not drown the others.
    unit = np.maximum(np.abs(fit.jacobian).max(axis=0), np.sqrt(fit.belief))
    unit[unit == 0] = 1.0
    slopes = root[:, None] * fit.jacobian / unit
    weighted = root * fit.residuals
    size = (weighted / fit.softness) ** 2
    curvature = (1 - size) / (1 + size) ** 2
    belief = np.diag(fit.belief / unit**2)
    field = SharedField.seen_by(fit, labels)
    moved = field.residuals()
    information = (curvature[:, None] * slopes).T @ slopes + belief
    pulled = ((curvature * root)[:, None] * slopes).T @ moved
    if fit.places is not None:
        # The places of lines are their slowest waves, which straightness alone knows nothing of.
        own = fit.places.jacobian / unit
        information += own.T @ own
        pulled += own.T @ fit.places.moved(field.leftward(fit.places.step))
    inverse = np.linalg.pinv(information)
    waves = Waves.of(weighted / (1 + size), slopes, labels)
    left = waves.left(inverse)
    middle = (waves.power(waves.heights, left)[:, None] * waves.slopes).T @ waves.slopes
    middle += fit.pull**2 * belief
    if fit.places is not None:
        off = fit.places.residuals
        free = np.maximum(1 - np.einsum("ni,ij,nj->n", own, inverse, own), 0.0)
        middle += (off @ off) / max(float(free.sum()), 1.0) * (own.T @ own)
    slow = waves.slow_ones_of(moved, root / (1 + size))
    middle += (pulled * mode_variances(waves, slow, left)) @ pulled.T
    whole = inverse @ middle @ inverse / np.outer(unit, unit)
    free_count = len(fit.free)
    return _within_belief(whole[:free_count, :free_count], fit)


def at_bound(fit: Fit) -> bool:
    """Whether a fit with a free centre ended where the model folds right behind the outermost points.

    It slid down a valley there, which lies open on: how steep the valley's end is tells nothing.
    """
    lam2 = fit.params[3] if len(fit.params) > 3 else 0.0
    fold = DivisionModel(fit.params[0], (0.0, 0.0), (1, 1), lam2=lam2).valid_radius
    return _centre_is_free(fit) and fold < NEAR_FOLD * _reach(fit)


def _within_belief(covariances: Floats, fit: Fit) -> Floats:
    """A covariance (k, k) by which the centre is nowhere known less than it was beforehand.

    Where it would be, that is taken for another measurement of it, and the other parameters go with it.
    """
    if not _centre_is_free(fit):
        return covariances
    centre = _centre_of(fit)
    spreads = _spreads(fit)
    for _ in range(2):
        values, ways = np.linalg.eigh(
            covariances[np.ix_(centre, centre)] / np.outer(spreads, spreads)
        )
        if values[-1] <= 1:
            break
        way = np.zeros(len(covariances))
        way[centre] = ways[:, -1] / spreads
        moved = covariances @ way
        covariances = covariances - np.outer(moved, moved) * (values[-1] - 1) / values[-1] ** 2
    return covariances


def _centre_is_free(fit: Fit) -> bool:
    return {1, 2} <= set(fit.free)


def _centre_of(fit: Fit) -> list[int]:
    """Where the centre is among the free parameters."""
    return [fit.free.index(i) for i in (1, 2)]


def _spreads(fit: Fit) -> Floats:
    """One standard deviation, px (2,), of what was believed of the centre."""
    return np.asarray(fit.pull / np.sqrt(fit.belief[_centre_of(fit)]), np.float64)


def _believed(fit: Fit) -> Floats:
    """The covariance (k, k) of the free parameters before any line was seen.

    Of the centre that is the prior's; a lambda that is bounded by the outermost points goes with the centre's
    distance from them.
    """
    spreads = np.zeros(len(fit.free))
    spreads[_centre_of(fit)] = _spreads(fit)
    relative = float(np.hypot(*_spreads(fit))) / _reach(fit)
    for i, power in ((0, 2), (3, 4)):
        if i in fit.free:
            spreads[fit.free.index(i)] = power * relative * abs(fit.params[i])
    return np.diag(spreads**2)


def _reach(fit: Fit) -> float:
    return float(np.linalg.norm(fit.points - fit.params[1:3], axis=1).max())
