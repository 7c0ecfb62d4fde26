"""Parallel lines whose ends nobody sees leave the centre open, and lambda with it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from endocal.calibration.fit.measured import Refined
from endocal.calibration.fit.plumb_line import Prior, fit_model
from endocal.calibration.fit.valley import with_valley
from endocal.calibration.measure.profiles import Measured
from endocal.model import DivisionModel

from ..scenes import TRUTH, line_points

PRIOR = Prior((float(TRUTH[1]), float(TRUTH[2])), (32.0, 24.0))
REACH = 300.0


def measured(points: np.ndarray, labels: np.ndarray) -> Measured:
    one = np.ones(len(points))
    return Measured(points, labels, one, np.outer(one, [20.0, 200.0, 200.0]), one)


def parallel(noise: float) -> tuple[np.ndarray, np.ndarray]:
    """Points and labels of twelve level lines as the lens bends them."""
    rng = np.random.default_rng(3)
    model = DivisionModel(TRUTH[0], tuple(TRUTH[1:]), (640, 480))
    t = np.linspace(-300, 300, 200)
    u = np.concatenate([np.stack([t, np.full(200, y)], axis=1) for y in np.linspace(-200, 200, 12)])
    points = model.distort(TRUTH[1:] + u)
    return points + rng.normal(0, noise, points.shape), np.repeat(np.arange(12), 200)


def refined(points: np.ndarray, labels: np.ndarray) -> Refined:
    m = measured(points, labels)
    fit = fit_model(points, labels, TRUTH, REACH, PRIOR, 0.1, m.sides)
    return Refined(fit, m, np.zeros(len(points), np.intp), frozenset())


def test_lambda_goes_with_an_open_centre_as_the_valley_is_curved() -> None:
    fitted = refined(*parallel(0.05))
    straight = fitted.covariance
    # It is open along the lines, as far as was believed beforehand; at the vertex nothing goes with it.
    along = float(np.sqrt(straight[1, 1]))
    assert 0.5 * PRIOR.spread[0] < along <= PRIOR.spread[0] * (1 + 1e-9)
    whole = with_valley(fitted, straight, REACH, PRIOR, 0.0)
    lam = fitted.fit.params[0]
    curved = 2 * (lam / (1 + lam * along**2) - lam)
    added = np.sqrt(whole[0, 0] - straight[0, 0])
    assert added == pytest.approx(np.sqrt(0.75) * abs(curved), rel=0.1)
    assert whole[1:, 1:] == pytest.approx(straight[1:, 1:])


def test_a_centre_that_is_told_or_given_has_no_valley() -> None:
    points, labels, _ = line_points(TRUTH, count=24, seed=1)
    fitted = refined(points, labels)
    covariance = fitted.covariance
    assert with_valley(fitted, covariance, REACH, PRIOR, 0.0) is covariance
    given = Prior(PRIOR.center, (0.0, 0.0))
    assert with_valley(fitted, covariance, REACH, given, 0.0) is covariance


def test_what_corners_tell_lies_in_no_valley() -> None:
    """They run in two directions; the points of lines beside them may be parallel."""
    fitted = refined(*parallel(0.05))
    told = replace(fitted, corners=(fitted.fit, fitted.measured.labels))
    covariance = fitted.covariance
    assert with_valley(told, covariance, REACH, PRIOR, 0.0) is covariance


def test_the_centre_is_nowhere_known_less_than_it_was_beforehand() -> None:
    """Errors that neighbours share count for more than those that the fit weighs the belief against."""
    points, labels = parallel(0.0)
    waves = np.repeat(np.random.default_rng(5).normal(0, 0.3, (len(points) // 40, 2)), 40, axis=0)
    deviations = np.sqrt(np.diag(refined(points + waves, labels).covariance))
    assert np.all(deviations[1:] <= np.array(PRIOR.spread) * (1 + 1e-9))
