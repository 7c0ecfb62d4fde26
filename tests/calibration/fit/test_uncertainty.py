from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from endocal.calibration.fit import uncertainty
from endocal.calibration.fit.plumb_line import Fit, Prior, fit_model
from endocal.calibration.fit.uncertainty import _within_belief, covariance
from endocal.model import DivisionModel

from ..scenes import TRUTH, line_points

PRIOR = Prior((319.5, 239.5), (32.0, 24.0))
START = np.array([-1.5e-6, 319.5, 239.5])
# Which way parallel lines run.
ALONG, ACROSS = np.array([0.96, 0.28]), np.array([-0.28, 0.96])


def fitted(points: np.ndarray, labels: np.ndarray, prior: Prior = PRIOR) -> Fit:
    """Fit as the calibration does in the end: two or three standard deviations are no outlier."""
    return fit_model(points, labels, START, 300, prior, softness=0.15)


def stated(fit: Fit, labels: np.ndarray) -> np.ndarray:
    """One standard deviation of each free parameter."""
    return np.sqrt(np.diag(covariance(fit, labels)))


def spread_of_z(errors: list[np.ndarray], sigmas: list[np.ndarray]) -> np.ndarray:
    return np.sqrt(np.mean((np.array(errors) / np.array(sigmas)) ** 2, axis=0))


def one_across() -> tuple[np.ndarray, np.ndarray]:
    """Points and labels of twelve parallel lines, and of a last one that alone runs across.

    The others leave the centre open along themselves.
    """
    model = DivisionModel(TRUTH[0], tuple(TRUTH[1:]), (640, 480))
    t = np.linspace(-330, 330, 220)
    along = [np.stack([t, np.full(220, y)], axis=1) for y in np.linspace(-200, 200, 12)]
    straight = np.concatenate([*along, np.stack([np.full(220, 180.0), t * 0.6], axis=1)])
    turned = straight @ np.array([ALONG, ACROSS])
    return model.distort(TRUTH[1:] + turned), np.repeat(np.arange(13), 220)


def along_and_across(fit: Fit, labels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How far the centre is off along those parallel lines and across them, px, and what is stated of it."""
    axes = np.array([ALONG, ACROSS])
    both = axes @ covariance(fit, labels)[1:3, 1:3] @ axes.T
    return axes @ (fit.params - TRUTH)[1:3], np.sqrt(np.diag(both))


@pytest.mark.parametrize("shared", [0.0, 0.9, 0.98])
def test_errors_that_neighbours_share_are_stated(shared: float) -> None:
    """Each point errs as its neighbour, but for a part of its own: slow waves move the model more."""
    errors, sigmas = [], []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        points, labels, normals = line_points(TRUTH, count=24, seed=seed)
        own = rng.normal(0, 0.03 * np.sqrt(1 - shared**2), len(points))
        off = lfilter([1.0], [1.0, -shared], own)
        fit = fitted(points + off[:, None] * normals, labels)
        errors.append(fit.params - TRUTH)
        sigmas.append(stated(fit, labels))
    z = spread_of_z(errors, sigmas)
    assert np.all((z > 0.7) & (z < 1.4)), z


def test_what_one_line_alone_tells_is_stated_by_how_the_others_err() -> None:
    exact, labels = one_across()
    errors, sigmas = [], []
    for seed in range(40):
        # Each point is the mean of five profiles, as those that are measured.
        raw = np.random.default_rng(seed).normal(0, 0.1, (len(exact) + 4, 2))
        fit = fitted(exact + sum(raw[i : i + len(exact)] for i in range(5)) / 5, labels)
        error, sigma = along_and_across(fit, labels)
        errors.append(error)
        sigmas.append(sigma)
    z = spread_of_z(errors, sigmas)
    assert np.all((z > 0.7) & (z < 1.4)), z
    # One statement is much as the next: it rests on all lines.
    assert np.all(np.std(sigmas, axis=0) < 0.3 * np.mean(sigmas, axis=0))


def test_a_noisy_line_is_known_to_be_one() -> None:
    exact, labels = one_across()
    sigmas = []
    for across in (0.05, 0.2):
        noise = np.where(labels == 12, across, 0.05)[:, None]
        off = np.random.default_rng(3).normal(0, 1, exact.shape) * noise
        sigmas.append(along_and_across(fitted(exact + off, labels), labels)[1])
    # The centre along the others is told by this line alone; across them it is not.
    assert sigmas[1][0] > 2 * sigmas[0][0]
    assert sigmas[1][1] < 1.5 * sigmas[0][1]


def test_what_was_believed_beforehand_is_known_still() -> None:
    """Parallel lines alone tell nothing of the centre along themselves."""
    exact, labels = one_across()
    own = labels < 12
    points = exact[own] + np.random.default_rng(1).normal(0, 0.05, exact[own].shape)
    sigma = along_and_across(fitted(points, labels[own]), labels[own])[1]
    assert 15 < sigma[0] < 32


def test_nothing_is_stated_of_a_centre_that_was_given() -> None:
    points, labels, _ = line_points(TRUTH)
    fit = fitted(points, labels, Prior(tuple(TRUTH[1:]), (0.0, 0.0)))
    assert covariance(fit, labels).shape == (1, 1)


def test_growth_that_moves_next_to_nothing_takes_nothing_from_the_others() -> None:
    """All edges of a small piece of a board are grown alike: their differences are rounding errors."""
    points, labels, normals = line_points(TRUTH, count=24)
    rng = np.random.default_rng(4)
    points = points + rng.normal(0, 0.03, len(points))[:, None] * normals
    column = 1e-11 * rng.normal(0, 1, (len(points), 1))
    fits = [
        fit_model(points, labels, START, 300, PRIOR, softness=0.15, growth=growth)
        for growth in (None, column)
    ]
    alone, beside = (stated(fit, labels) for fit in fits)
    np.testing.assert_allclose(beside, alone, rtol=1e-3)
    assert np.all(alone > 0)


def test_what_bright_areas_may_grow_by_leaves_lambda_as_unsure() -> None:
    """Growth that moves all points as lambda does hides it: by half a px is what it is believed to be."""
    points, labels, normals = line_points(TRUTH, count=24, seed=1)
    points = points + np.random.default_rng(1).normal(0, 0.03, len(points))[:, None] * normals
    alone = fitted(points, labels)
    # As far as a step of lambda moves them; seen once, for which way is left on each line.
    column = 1e-8 * alone.jacobian[:, :1]
    for _ in range(2):
        fit = fit_model(points, labels, alone.params, 300, PRIOR, softness=0.15, growth=column)
        column = fit.jacobian[:, 3:]
    np.testing.assert_allclose(fit.jacobian[:, 3], 1e-8 * fit.jacobian[:, 0], atol=1e-3)
    expected = np.hypot(stated(alone, labels)[0], 0.5e-8)
    assert stated(fit, labels)[0] == pytest.approx(expected, rel=0.02)


def test_a_robust_fit_knows_as_much_as_what_it_leaves_of_residuals(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Huber's asymptotic variance, E psi^2 / (E psi')^2, of white noise of half a softness."""
    points, labels, normals = line_points(TRUTH, count=24, seed=1)
    noise, softness = 0.075, 0.15
    off = np.random.default_rng(1).normal(0, noise, len(points))
    wide = Prior(PRIOR.center, (1e4, 1e4))
    fit = fit_model(points + off[:, None] * normals, labels, TRUTH, 300, wide, softness)
    z = np.random.default_rng(2).normal(0, noise, 200_000)
    size = (z / softness) ** 2
    psi, slope = z / (1 + size), (1 - size) / (1 + size) ** 2
    # The noise is known to be white, and nothing is shared.
    monkeypatch.setattr(
        uncertainty.Waves,
        "power",
        lambda waves, heights, left: np.full(len(heights), np.mean(heights**2)),
    )
    monkeypatch.setattr(uncertainty, "mode_variances", lambda waves, moved, left: np.zeros(36))
    information = fit.jacobian.T @ fit.jacobian * slope.mean() ** 2 / np.mean(psi**2)
    expected = np.sqrt(np.diag(np.linalg.inv(information)))
    assert stated(fit, labels) == pytest.approx(expected, rel=0.05)


def test_of_a_fit_at_lambdas_bound_what_was_believed_is_stated() -> None:
    """How steep the end of a valley is tells nothing of how far it lies from the truth."""
    points, labels, _ = line_points(TRUTH, count=24, seed=1)
    fit = fitted(points, labels)
    reach = float(np.linalg.norm(points - fit.params[1:3], axis=1).max())
    folding = np.array([-1 / (1.01 * reach) ** 2, *fit.params[1:]])
    assert np.all(stated(fit, labels)[1:] < np.array(PRIOR.spread) / 10)
    sigma = stated(replace(fit, params=folding), labels)
    assert sigma[1:] == pytest.approx(PRIOR.spread)
    assert sigma[0] == pytest.approx(2 * np.hypot(*PRIOR.spread) / reach * -folding[0])
    # A second parameter that is bounded by the points goes with the fourth power of their reach.
    two = replace(
        fit,
        params=np.append(folding, -1.0),
        free=[0, 1, 2, 3],
        belief=np.append(fit.belief, 0.0),
    )
    assert stated(two, labels)[3] == pytest.approx(4 * np.hypot(*PRIOR.spread) / reach)
    # A given centre leaves no such valley.
    given = fitted(points, labels, Prior(tuple(fit.params[1:3]), (0.0, 0.0)))
    held = replace(given, params=folding)
    assert stated(held, labels) == pytest.approx(stated(given, labels), rel=0.1)


def believed_and_stated(*deviations: float) -> tuple[Fit, np.ndarray]:
    """A fit, and a covariance by which the centre is off by so many of what was believed along two ways."""
    points, labels, _ = line_points(TRUTH)
    way = np.array([[0.8, -0.6], [0.6, 0.8]]) * deviations
    root = np.zeros((3, 3))
    root[1:, 1:] = np.array(PRIOR.spread)[:, None] * way
    # Lambda goes with the centre, and has errors of its own.
    root[0] = [2e-8, 5e-8, -3e-8]
    return fitted(points, labels), root @ root.T


@pytest.mark.parametrize("deviations", [(3.0, 0.5), (3.0, 2.0)])
def test_a_centre_stated_to_be_unknown_is_known_as_before_and_no_less(
    deviations: tuple[float, float],
) -> None:
    """As if it were measured once more, as well as it takes: all other parameters go with it."""
    fit, stated_ = believed_and_stated(*deviations)
    unit = np.array([1.0, *PRIOR.spread])
    held = _within_belief(stated_, fit)
    values, ways = np.linalg.eigh((stated_ / np.outer(unit, unit))[1:, 1:])
    assert np.sqrt(values) == pytest.approx(sorted(deviations))
    got = np.linalg.eigvalsh((held / np.outer(unit, unit))[1:, 1:])
    assert got == pytest.approx(np.minimum(values, 1.0))
    # Of a measurement along a way information adds up: 1 - 1 / variance makes up what is missing.
    information = np.linalg.inv(stated_)
    for value, way in zip(values, ways.T, strict=True):
        along = np.append(0.0, way) / unit
        information += np.outer(along, along) * max(1 - 1 / value, 0.0)
    size = np.sqrt(np.outer(np.diag(held), np.diag(held)))
    np.testing.assert_allclose(held / size, np.linalg.inv(information) / size, atol=1e-6)


def test_a_centre_known_better_than_before_is_stated_as_it_is() -> None:
    fit, stated_ = believed_and_stated(0.9, 0.5)
    assert np.array_equal(_within_belief(stated_, fit), stated_)
