"""A smooth field that moves all lines of a picture: what is stated of a fit to them."""

from __future__ import annotations

import numpy as np
import pytest

import endocal.calibration.fit.uncertainty as uncertainty
from endocal.calibration.board.lifted import Corners
from endocal.calibration.fit.corner_fit import fit_corners
from endocal.calibration.fit.grid_fit import fit_grid
from endocal.calibration.fit.plumb_line import Fit, Prior, fit_model
from endocal.calibration.fit.shared_field import HIGHEST, LOWEST, SharedField, _expected
from endocal.calibration.fit.uncertainty import covariance
from endocal.calibration.measure.growth import growth_columns
from endocal.calibration.measure.profiles import Measured
from endocal.calibration.straightness import residuals
from endocal.model import DivisionModel

from ..scenes import TRUTH, line_points
from ..sheets import board

PRIOR = Prior((319.5, 239.5), (32.0, 24.0))
START = np.array([-1.5e-6, 319.5, 239.5])
NOISE = 0.03


def bumps(rng: np.random.Generator, points: np.ndarray, strength: float) -> np.ndarray:
    """Displacements (n, 2) px at points: waves in all directions, some 300 px long or longer."""
    out = np.zeros_like(points)
    for _ in range(12):
        way, phase = rng.normal(0, 1 / 110, 2), rng.uniform(0, 2 * np.pi)
        out += rng.normal(0, strength / np.sqrt(6), 2) * np.cos(points @ way + phase)[:, None]
    return out


def fitted(points: np.ndarray, labels: np.ndarray) -> Fit:
    fit = fit_model(points, labels, START, 300, PRIOR, softness=0.3)
    return fit_model(points, labels, fit.params, 300, PRIOR, softness=max(0.05, 2 * fit.sigma))


def z_scores(strength: float, count: int = 16) -> tuple[np.ndarray, list[np.ndarray]]:
    """Errors over stated standard deviations of fits to points in a field, and the latter."""
    scores, sigmas = [], []
    for seed in range(count):
        rng = np.random.default_rng(seed)
        points, labels, _ = line_points(TRUTH, count=24, seed=seed)
        moved = points + bumps(rng, points, strength) + rng.normal(0, NOISE, points.shape)
        fit = fitted(moved, labels)
        sigmas.append(np.sqrt(np.diag(covariance(fit, labels))))
        scores.append((fit.params - TRUTH) / sigmas[-1])
    return np.array(scores), sigmas


@pytest.fixture
def no_field(monkeypatch: pytest.MonkeyPatch) -> None:
    """Lines that err each for itself, whatever they share."""
    monkeypatch.setattr(uncertainty, "mode_variances", lambda waves, moved, left: np.zeros(36))


@pytest.mark.parametrize("strength", [0.03, 0.3])
def test_what_lines_share_is_stated(strength: float) -> None:
    z = np.sqrt(np.mean(z_scores(strength)[0] ** 2, axis=0))
    assert np.all((z > 0.5) & (z < 1.4)), z


def test_as_if_lines_erred_apart_too_little_would_be_stated(no_field: None) -> None:
    z = np.sqrt(np.mean(z_scores(0.3)[0] ** 2, axis=0))
    assert np.all(z > 1.5), z


def test_where_nothing_is_shared_next_to_nothing_is_added(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with_field = np.array(z_scores(0.0)[1])
    monkeypatch.setattr(uncertainty, "mode_variances", lambda waves, moved, left: np.zeros(36))
    without = np.array(z_scores(0.0)[1])
    ratio = with_field / without
    assert np.all(ratio >= 1)
    assert np.median(ratio) < 1.03
    assert np.quantile(ratio, 0.9) < 1.1


def test_noise_alone_adds_a_few_thousandths_of_its_own_variance_at_most() -> None:
    """The odds that there is a field at all are low; where one is as strong as noise it is told."""
    degrees = np.arange(LOWEST, HIGHEST + 1)
    degree = np.tile(np.repeat(degrees, degrees + 1), 2)
    added: dict[float, list[float]] = {0.0: [], 3.0: []}
    for seed in range(100):
        rng = np.random.default_rng(seed)
        seen = 30 * np.linalg.qr(rng.normal(0, 1, (len(degree), len(degree))))[0][:30]
        for field, values in added.items():
            told = rng.normal(0, np.sqrt(1 + field**2), 30)
            values.append(float((seen**2 @ _expected(told, seen, degree)).mean()))
    assert np.mean(added[0.0]) < 0.003
    assert np.mean(added[3.0]) == pytest.approx(9.0, rel=0.2)


def test_lines_without_any_error_are_told_exactly() -> None:
    points, labels, _ = line_points(TRUTH, count=24)
    sigma = np.sqrt(np.diag(covariance(fitted(points, labels), labels)))
    assert np.all(np.isfinite(sigma))
    assert sigma[1] < 1e-3


def along_field(points: np.ndarray, step: float) -> np.ndarray:
    """Points moved by a field of the third degree."""
    x, y = ((points - 320) / 300).T
    return points + step * np.stack([x * y * y, x**2 - x**3], axis=1)


def by_modes(field: SharedField, points: np.ndarray) -> np.ndarray:
    """How much of each mode makes the part of that field that the modes hold."""
    moved = along_field(points, 1.0) - points
    return np.concatenate([field.modes.T @ column / len(points) for column in moved.T])


def linear(points: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """What is linear of displacements (n, 2), which no mode holds."""
    basis = np.column_stack([np.ones(len(points)), points])
    return np.asarray(basis @ np.linalg.lstsq(basis, moved, rcond=None)[0])


def test_a_field_moves_residuals_as_it_moves_points() -> None:
    points, labels, _ = line_points(TRUTH, count=24)
    points += np.random.default_rng(0).normal(0, NOISE, points.shape)
    fit = fitted(points, labels)
    field = SharedField.seen_by(fit, labels)
    moved = along_field(points, 1.0) - points
    rest = moved - linear(points, moved)
    step = 1e-3
    weights = 1 / (1 + (fit.residuals / fit.softness) ** 2)
    ahead, behind = (
        residuals(points + way * step * rest, labels, fit.params, weights) for way in (1, -1)
    )
    expected = (ahead - behind) / (2 * step)
    got = field.residuals() @ by_modes(field, points)
    np.testing.assert_allclose(got, expected, atol=0.01 * np.abs(expected).max())


def test_a_field_moves_residuals_of_corners_as_it_moves_them() -> None:
    lens = DivisionModel(-6e-6, (325.0, 233.0), (640, 480))
    rows, cols = np.indices((9, 12))
    straight = np.stack([cols * 40 - 210 + rows, rows * 38 - 160 - 2 * cols], axis=-1)
    points = lens.distort(lens.center + straight.reshape(-1, 2).astype(float))
    points += np.random.default_rng(0).normal(0, 0.05, points.shape)
    places = np.stack([rows.ravel(), cols.ravel()], axis=1)
    prior = Prior(lens.center, (0.0, 0.0))

    def fit_of(corners: np.ndarray) -> tuple[Fit, np.ndarray]:
        found = fit_corners([Corners(corners, places)], np.array([-6e-6, *lens.center]), prior, 0.0)
        assert found is not None
        return found

    fit, labels = fit_of(points)
    field = SharedField.seen_by(fit, labels)
    moved = along_field(points, 1.0) - points
    rest = moved - linear(points, moved)
    step = 1e-2
    ahead, behind = (fit_of(points + way * step * rest)[0] for way in (1, -1))
    slope = fit.jacobian[:, 0] * (ahead.params[0] - behind.params[0])
    expected = (ahead.residuals - behind.residuals - slope) / (2 * step)
    got = field.residuals() @ by_modes(field, fit.points)
    np.testing.assert_allclose(got, expected, atol=0.03 * np.abs(expected).max())


def grid_fit_of(m: Measured, points: np.ndarray) -> Fit:
    """The model that a board's grid tells, its points being elsewhere."""
    seen = Measured(points, m.labels, m.sides, m.levels, m.information)
    columns = growth_columns(m.sides, m.levels, m.labels)
    start = np.array([-0.5e-6, 319.5, 239.5])
    plain = fit_model(points, m.labels, start, 330.0, PRIOR, 0.5, m.sides, columns)
    found = fit_grid(seen, np.zeros(len(m.points), np.intp), plain, 330.0)
    assert found is not None
    assert found.places is not None
    return found


@pytest.mark.parametrize("mode", [0, 12])
def test_what_is_stated_for_a_mode_of_a_field_is_how_far_it_moves_the_grid_fit(
    monkeypatch: pytest.MonkeyPatch, mode: int
) -> None:
    m = board(seed=3)
    fit = grid_fit_of(m, m.points)
    modes = SharedField.seen_by(fit, m.labels).modes
    count = modes.shape[1]

    def covariance_with(variance: float) -> np.ndarray:
        chosen = variance * (np.arange(2 * count) == mode)
        monkeypatch.setattr(uncertainty, "mode_variances", lambda waves, moved, left: chosen)
        return covariance(fit, m.labels)

    added = covariance_with(1.0) - covariance_with(0.0)
    step = 0.02
    way = np.zeros_like(m.points)
    way[:, mode // count] = step * modes[:, mode % count]
    ahead, behind = (grid_fit_of(m, m.points + sign * way).params for sign in (1, -1))
    moved = (ahead - behind) / (2 * step)
    size = np.sqrt(np.diag(covariance_with(0.0)))
    scaled, expected = added / np.outer(size, size), np.outer(moved / size, moved / size)
    np.testing.assert_allclose(scaled, expected, atol=0.2 * np.abs(expected).max())


def test_a_field_moves_the_grid_fit_as_is_stated() -> None:
    """The model that a board's grid tells follows a field as the places of its lines and their points do."""
    m = board(seed=3)
    fit = grid_fit_of(m, m.points)
    field = SharedField.seen_by(fit, m.labels)
    moved = along_field(m.points, 1.0) - m.points
    rest = moved - linear(m.points, moved)
    parts = by_modes(field, m.points)
    weights = 1 / (1 + (fit.residuals / fit.softness) ** 2)
    unit = np.abs(fit.jacobian).max(axis=0)
    slopes, own = fit.jacobian / unit, fit.places.jacobian / unit
    information = (
        (weights[:, None] * slopes).T @ slopes + own.T @ own + np.diag(fit.belief / unit**2)
    )
    pulled = (weights[:, None] * slopes).T @ field.residuals()
    pulled += own.T @ fit.places.moved(field.leftward(fit.places.step))
    expected = -np.linalg.solve(information, pulled @ parts)[:3] / unit[:3]
    step = 0.02
    ahead, behind = (grid_fit_of(m, m.points + way * step * rest).params for way in (1, -1))
    got = (ahead - behind) / (2 * step)
    np.testing.assert_allclose(got, expected, atol=0.1 * np.abs(expected).max(), rtol=0.15)
