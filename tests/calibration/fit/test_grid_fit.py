"""What a board's regularity tells of the lens, on points whose truth is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from endocal.calibration.board.numbered import numbered_lines
from endocal.calibration.fit.grid_fit import fit_grid
from endocal.calibration.fit.plumb_line import Fit, Prior, fit_model
from endocal.calibration.fit.uncertainty import covariance
from endocal.calibration.measure.growth import growth_columns
from endocal.calibration.measure.profiles import Measured

from ..scenes import grid
from ..sheets import LENS, ROWS, bars, board

PRIOR = Prior((319.5, 239.5), (32.0, 24.0))
REACH = 330.0


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
    results = [both(board(seed=seed)) for seed in range(16)]
    before, _, after, sigma = zip(*results, strict=True)
    assert np.all(rms(after) < 0.8 * rms(before)), rms(after) / rms(before)
    spread = np.sqrt(np.mean(np.divide(after, sigma) ** 2, axis=0))
    assert np.all((spread > 0.75) & (spread < 1.3)), spread


@pytest.mark.parametrize("astray", [0.01, 0.1])
def test_lines_printed_astray_have_no_say(astray: float) -> None:
    """A hundredth of a square is half a pixel here, ten times the noise of a point."""
    results = [both(board(seed=seed, astray=astray)) for seed in range(12)]
    before, sigma, after, _ = zip(*results, strict=True)
    assert np.all(rms(after) < 1.1 * rms(before)), rms(after) / rms(before)
    moved = np.abs(np.subtract(after, before)) / sigma
    assert np.median(moved) < 0.3


@pytest.mark.parametrize("wrong", [0.05, 0.5])
def test_one_row_out_of_place_moves_nothing(wrong: float) -> None:
    """Its number is wrong, or it is no row: a twentieth of a square is hundreds of standard deviations."""
    results = [both(board(seed=seed, wrong=wrong)) for seed in range(12)]
    before, _, after, _ = zip(*results, strict=True)
    assert np.all(rms(after) < 0.9 * rms(before)), rms(after) / rms(before)


def test_two_pictures_of_a_board_have_a_grid_each() -> None:
    one, other = board(seed=1), board(seed=2)
    moved = Measured(other.points, other.labels + 16, other.sides, other.levels, other.information)
    m = Measured.joined([one, moved], np.append(one.labels, moved.labels))
    view = np.repeat([0, 1], [len(one.points), len(other.points)])
    lines = numbered_lines(m, view, LENS)
    assert np.bincount(lines.board).tolist() == [16, 16]
    assert lines.line.tolist() == list(range(32))
    found = fit_grid(m, view, plain(m), REACH)
    assert found is not None
    sigma = np.sqrt(np.diag(covariance(found, m.labels)))
    assert np.all(np.abs(found.params - LENS) < 3 * sigma)


def test_a_model_held_at_its_bound_has_no_grid() -> None:
    m = board()
    first = plain(m)
    held = replace(first, jacobian=first.jacobian * (np.arange(first.jacobian.shape[1]) != 0))
    assert fit_grid(m, np.zeros(len(m.points), np.intp), held, REACH) is None


def test_without_numbered_lines_there_is_no_grid() -> None:
    m = board()
    rows = m.take(m.labels < ROWS - 1)
    assert fit_grid(rows, np.zeros(len(rows.points), np.intp), plain(m), REACH) is None
    few = grid(4)
    assert len(numbered_lines(few, np.zeros(len(few.points), np.intp), LENS).line) == 0


@pytest.mark.parametrize("grown", [0.0, 0.4, 1.0])
def test_the_bars_distances_tell_more_than_their_straight_lines(grown: float) -> None:
    """Most of lam; of the centre what two rows of ends have in common. Growth costs little of it."""
    results = [both(bars(seed=seed, grown=grown)) for seed in range(16)]
    before, _, after, sigma = zip(*results, strict=True)
    share = rms(after) / rms(before)
    assert np.all(share < (0.75, 0.95)), share
    spread = np.sqrt(np.mean(np.divide(after, sigma) ** 2, axis=0))
    assert np.all((spread > 0.6) & (spread < 1.5)), spread


def test_what_bright_bars_grow_by_is_found_beside_the_grid() -> None:
    """However noisy the bars: a solver that stops half-way leaves some of it to the lens."""
    for seed in range(12):
        (_, _, there, sigma), (_, _, grown, _) = (
            both(bars(noise=0.15, seed=seed, grown=g)) for g in (0.0, 1.0)
        )
        assert np.all(np.abs(grown - there) < 0.45 * sigma), seed


@pytest.mark.parametrize(("astray", "most"), [(0.002, 1.3), (0.02, 1.1)])
def test_bars_of_all_widths_have_no_say(astray: float, most: float) -> None:
    """A tenth of a px, at first: what the grid explains of that itself must not pass for evenness."""
    results = [both(bars(seed=seed, astray=astray)) for seed in range(16)]
    before, _, after, _ = zip(*results, strict=True)
    assert np.all(rms(after) < most * rms(before)), rms(after) / rms(before)


def test_one_row_of_ends_is_no_grid() -> None:
    m = bars(rows=(ROWS / 2,))
    assert fit_grid(m, np.zeros(len(m.points), np.intp), plain(m), REACH) is None
