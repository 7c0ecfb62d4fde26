import numpy as np
import pytest

from endocal.calibration.fit.plumb_line import Prior, fit_model, folds, inlying, second_range
from endocal.calibration.measure.growth import growth_columns
from endocal.calibration.straightness import LEAST_DENOMINATOR
from endocal.model import DivisionModel

from ..scenes import TRUTH, line_points

PRIOR = Prior((319.5, 239.5), (32.0, 24.0))
START = np.array([-1.5e-6, 319.5, 239.5])


def fitted(points, labels, start=START, softness=0.01, prior=PRIOR, radius=300.0, **more):
    """Fit as the calibration does: softly first, so that no start is an outlier, then sharply."""
    soft = fit_model(points, labels, start, radius, prior, 2.0, **more)
    return fit_model(points, labels, soft.params, radius, prior, softness, **more)


def test_the_truth_is_recovered_exactly_from_exact_points() -> None:
    points, labels, _ = line_points(TRUTH)
    fit = fitted(points, labels)
    # The prior's pull at this softness.
    assert fit.params[0] == pytest.approx(TRUTH[0], rel=1e-4)
    assert fit.params[1:] == pytest.approx(TRUTH[1:], abs=0.01)


def test_outliers_hardly_matter() -> None:
    points, labels, normals = line_points(TRUTH)
    rng = np.random.default_rng(5)
    bad = rng.random(len(points)) < 0.1
    noisy = (
        points
        + (rng.normal(0, 0.05, len(points)) + bad * rng.uniform(1, 3, len(points)))[:, None]
        * normals
    )
    fit = fit_model(noisy, labels, START, 300, PRIOR, softness=0.1)
    assert fit.params[0] == pytest.approx(TRUTH[0], rel=0.01)
    assert fit.params[1:] == pytest.approx(TRUTH[1:], abs=1.0)


def test_what_is_believed_of_the_centre_weighs_as_it_should_beside_noise() -> None:
    """A belief as sure as the lines themselves, and far off, moves the centre by what Bayes' rule says."""
    exact, labels, _ = line_points(TRUTH, count=12)
    noise, wide = 0.2, 1e4
    moved = []
    for seed in range(8):
        # Each point is the mean of five profiles, as those that are measured: it errs as its neighbours do.
        raw = np.random.default_rng(seed).normal(0, noise, (len(exact) + 4, 2))
        points = exact + sum(raw[i : i + len(exact)] for i in range(5)) / 5
        free = fit_model(points, labels, TRUTH, 300, Prior(tuple(TRUTH[1:]), (wide, wide)), 0.2)
        # So many points that err together tell as much as if each had the noise of one profile.
        information = free.jacobian[:, :3].T @ free.jacobian[:, :3] / noise**2
        spread = np.sqrt(np.linalg.inv(information)[1, 1])
        belief = Prior((free.params[1] - 3 * spread, free.params[2]), (spread, wide))
        fit = fit_model(points, labels, free.params, 300, belief, 2 * free.sigma)
        moved.append((free.params[1] - fit.params[1]) / spread)
    # Half of the way, and a little more: the robust loss takes two thirds of what residuals tell.
    assert 1.5 <= np.mean(moved) < 2.0


def test_a_given_centre_is_kept() -> None:
    points, labels, _ = line_points(TRUTH)
    prior = Prior(tuple(TRUTH[1:]), (0.0, 0.0))
    fit = fitted(points, labels, np.array([-1e-6, *TRUTH[1:]]), prior=prior)
    assert tuple(fit.params[1:]) == tuple(TRUTH[1:])
    assert fit.params[0] == pytest.approx(TRUTH[0], rel=1e-5)


def test_two_parameters_are_recovered_and_do_not_fold() -> None:
    truth = np.array([-1.2e-6, 325.0, 233.0, -9e-12])
    points, labels, _ = line_points(truth, radius=260)
    start = np.array([-2e-6, 319.5, 239.5, 0.0])
    fit = fitted(points, labels, start, radius=260.0)
    assert fit.params[0] == pytest.approx(truth[0], rel=0.01)
    assert fit.params[3] == pytest.approx(truth[3], rel=0.01)
    assert DivisionModel(fit.params[0], (0, 0), (1, 1), lam2=fit.params[3]).valid_radius < 560
    kept = fitted(points, labels, start, radius=260.0, monotonic=600.0)
    assert DivisionModel(kept.params[0], (0, 0), (1, 1), lam2=kept.params[3]).valid_radius > 594


@pytest.mark.parametrize("lam", [-6e-6, -1e-6, 0.0, 2e-6])
def test_a_second_parameter_may_be_what_leaves_the_model_monotonic(lam: float) -> None:
    """At the ends of its range the denominator, or the slope's, is at its least somewhere; beyond, below."""
    radius = 300.0
    q = np.linspace(0, radius, 2000) ** 2

    def least(lam2: float) -> float:
        return float(min((1 + lam * q + lam2 * q**2).min(), (1 - lam * q - 3 * lam2 * q**2).min()))

    low, high = second_range(lam, radius)
    for end, inside in ((low, 1), (high, -1)):
        assert least(end) == pytest.approx(LEAST_DENOMINATOR, abs=1e-3)
        for step, kept in ((1e-3 * inside, True), (-1e-3 * inside, False)):
            params = np.array([lam, 320.0, 240.0, end + step * (high - low)])
            assert folds(params, radius) is not kept
            assert (least(params[3]) > LEAST_DENOMINATOR) is kept


def test_points_follow_their_lines_within_five_standard_deviations() -> None:
    for sigma, usual in ((0.1, 0.1), (0.0, 0.02)):
        assert inlying(usual * np.array([-5.01, -4.99, 0.0, 4.99, 5.01]), sigma).tolist() == [
            *(False, True, True, True, False)
        ]


def leftward(points, labels, normals):
    """The normals turned to the left of the way from each line's first point to its last."""
    ways = np.stack([points[labels == i][-1] - points[labels == i][0] for i in np.unique(labels)])
    left = np.stack([-ways[:, 1], ways[:, 0]], axis=1)[labels]
    return normals * np.sign(np.einsum("ij,ij->i", normals, left))[:, None]


def test_one_sided_lines_tell_how_much_bright_areas_grow() -> None:
    points, labels, normals = line_points(TRUTH, count=20)
    sides = np.where(labels % 2 == 0, 1.0, -1.0)
    left = leftward(points, labels, normals)
    grown = points + 0.3 * sides[:, None] * left
    plain = fitted(grown, labels)
    aware = fitted(grown, labels, sides=sides, growth=sides[:, None])
    # A line moved by as much everywhere in the distorted picture is no longer straight: not by 2 %.
    assert abs(aware.params[0] / TRUTH[0] - 1) < 0.002
    assert np.abs(aware.residuals).max() < np.abs(plain.residuals).max() / 2


def test_growth_that_follows_the_light_is_taken_off() -> None:
    """Bright areas that grow where it is light, and not at the dark rim, bend their edges."""
    points, labels, normals = line_points(TRUTH, count=20)
    sides = np.where(labels % 2 == 0, 1.0, -1.0)
    bright = 230 - 0.0015 * np.linalg.norm(points - TRUTH[1:], axis=1) ** 2
    levels = np.stack([0.2 * bright, bright], axis=1)
    growth = 0.004 * (bright - 150)
    left = leftward(points, labels, normals)
    grown = points + (sides * growth)[:, None] * left
    plain = fitted(grown, labels)
    columns = growth_columns(sides, levels, labels)
    aware = fitted(grown, labels, sides=sides, growth=columns)
    assert abs(plain.params[0] / TRUTH[0] - 1) > 0.01
    assert abs(aware.params[0] / TRUTH[0] - 1) < 0.002
    assert aware.sigma < plain.sigma / 5
