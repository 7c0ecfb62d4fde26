"""What a board's regularity tells of the lens, on points whose truth is known."""

from __future__ import annotations

import numpy as np
import pytest

from endocal.calibration.fit.grid_fit import fit_grid, numbered_lines
from endocal.calibration.fit.plumb_line import Fit, Prior, fit_model
from endocal.calibration.fit.uncertainty import covariance
from endocal.calibration.measure.growth import growth_columns
from endocal.calibration.measure.profiles import Measured
from endocal.model import DivisionModel

from ..scenes import grid

PRIOR = Prior((319.5, 239.5), (32.0, 24.0))
REACH = 330.0
# A weak one, of which the straightness of lines tells little.
LENS = np.array([-0.8e-6, 325.0, 233.0])
SQUARE, FOCAL = 0.2, 500.0
ROWS, COLUMNS = 8, 10
# Neighbours err alike, as averaged profiles do.
AVERAGED = 6


def sheet(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Where places (n,), (n,) on a tilted sheet, in squares from its middle, are seen, (n, 2) px."""
    at = np.stack([x, y, np.zeros_like(x)], axis=1) * SQUARE
    turn, tilt = np.deg2rad(12), np.deg2rad(25)
    cos, sin = np.cos(turn), np.sin(turn)
    at = at @ np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]]).T
    cos, sin = np.cos(tilt), np.sin(tilt)
    at = at @ np.array([[1, 0, 0], [0, cos, -sin], [0, sin, cos]]).T + (0.05, -0.05, 1.9)
    model = DivisionModel(LENS[0], tuple(LENS[1:]), (640, 480))
    return model.distort(FOCAL * at[:, :2] / at[:, 2:] + LENS[1:])


def seen(
    noise: float = 0.05,
    seed: int = 0,
    astray: float = 0.0,
    wrong: float = 0.0,
) -> Measured:
    """The lines of a board with noise (px); every line moved by a normal deviate of ``astray`` squares.

    One row is moved by ``wrong`` squares.
    """
    rng = np.random.default_rng(seed)
    parts: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
    for family, count, other in ((0, ROWS - 1, COLUMNS), (1, COLUMNS - 1, ROWS)):
        for k in range(count):
            t = np.linspace(-other / 2, other / 2, 32 * other + 1)
            off = k + 1 - (count + 1) / 2 + rng.normal(0, astray)
            if (family, k) == (0, 2):
                off += wrong
            place = (t, np.full(len(t), off))
            points = sheet(*(place if family == 0 else place[::-1]))
            way = np.gradient(points, axis=0)
            way /= np.linalg.norm(way, axis=1)[:, None]
            error = np.convolve(rng.normal(0, 1, len(t) + AVERAGED - 1), np.ones(AVERAGED), "valid")
            error *= noise / np.sqrt(AVERAGED)
            points = points + error[:, None] * np.stack([-way[:, 1], way[:, 0]], axis=1)
            cell = np.floor(t + other / 2).astype(int)
            clear = np.abs(t - np.rint(t)) > 0.1
            sides = np.where((cell + k + family) % 2, 1.0, -1.0)
            label = np.full(len(t), len(parts))
            parts.append((points[clear], label[clear], sides[clear]))
    points, labels, sides = (np.concatenate(p) for p in zip(*parts, strict=True))
    levels = rng.normal((40.0, 200.0), 5.0, (len(points), 2))
    return Measured(points, labels, sides, levels, np.ones(len(points)))


def plain(m: Measured) -> Fit:
    columns = growth_columns(m.sides, m.levels, m.labels)
    start = np.array([-0.5e-6, 319.5, 239.5])
    fit = fit_model(m.points, m.labels, start, REACH, PRIOR, 1.0, m.sides, columns)
    softness = max(0.02, 2 * fit.sigma)
    return fit_model(m.points, m.labels, fit.params, REACH, PRIOR, softness, m.sides, columns)


def both(m: Measured) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Errors and stated standard deviations of the plain fit, and of that with the grid."""
    first = plain(m)
    found = fit_grid(m, np.zeros(len(m.points), np.intp), first, REACH)
    assert found is not None
    sigma = [np.sqrt(np.diag(covariance(fit, m.labels))) for fit in (first, found)]
    return first.params - LENS, sigma[0], found.params - LENS, sigma[1]


def rms(errors: list[np.ndarray]) -> np.ndarray:
    """Of lam, and of the centre."""
    lam, cx, cy = np.sqrt(np.mean(np.square(errors), axis=0))
    return np.array([lam, np.hypot(cx, cy)])


def test_a_regular_board_tells_more_than_its_straight_lines() -> None:
    results = [both(seen(seed=seed)) for seed in range(40)]
    before, _, after, sigma = zip(*results, strict=True)
    assert np.all(rms(after) < 0.8 * rms(before)), rms(after) / rms(before)
    spread = np.sqrt(np.mean(np.divide(after, sigma) ** 2, axis=0))
    assert np.all((spread > 0.75) & (spread < 1.3)), spread


@pytest.mark.parametrize("astray", [0.01, 0.1])
def test_lines_printed_astray_have_no_say(astray: float) -> None:
    """A hundredth of a square is half a pixel here, ten times the noise of a point."""
    results = [both(seen(seed=seed, astray=astray)) for seed in range(20)]
    before, sigma, after, _ = zip(*results, strict=True)
    assert np.all(rms(after) < 1.1 * rms(before)), rms(after) / rms(before)
    moved = np.abs(np.subtract(after, before)) / sigma
    assert np.median(moved) < 0.3


def test_one_row_out_of_place_moves_nothing() -> None:
    """Its number is wrong, or it is no row: half a square is hundreds of standard deviations."""
    results = [both(seen(seed=seed, wrong=0.5)) for seed in range(12)]
    before, _, after, _ = zip(*results, strict=True)
    assert np.all(rms(after) < 0.9 * rms(before)), rms(after) / rms(before)


def test_two_pictures_of_a_board_have_a_grid_each() -> None:
    one, other = seen(seed=1), seen(seed=2)
    moved = Measured(other.points, other.labels + 16, other.sides, other.levels, other.information)
    m = Measured.joined([one, moved], np.append(one.labels, moved.labels))
    view = np.repeat([0, 1], [len(one.points), len(other.points)])
    lines = numbered_lines(m, view)
    assert np.bincount(lines.board).tolist() == [16, 16]
    assert lines.line.tolist() == list(range(32))
    found = fit_grid(m, view, plain(m), REACH)
    assert found is not None
    sigma = np.sqrt(np.diag(covariance(found, m.labels)))
    assert np.all(np.abs(found.params - LENS) < 3 * sigma)


def test_without_numbered_lines_there_is_no_grid() -> None:
    m = seen()
    rows = m.take(m.labels < ROWS - 1)
    assert fit_grid(rows, np.zeros(len(rows.points), np.intp), plain(m), REACH) is None
    few = grid(4)
    assert len(numbered_lines(few, np.zeros(len(few.points), np.intp)).line) == 0
