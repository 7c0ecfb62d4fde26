"""Chessboards found and grown to their last corner, and the lens that their corners tell."""

import json
from pathlib import Path

import numpy as np
import pytest

from endocal.calibration.board.corners import _without_outliers, find_board
from endocal.calibration.board.lifted import Corners, fit, linear_solution, see
from endocal.calibration.image.picture import fields, to_grey
from endocal.files import read_image
from endocal.model import DivisionModel
from endocal.synth.board import render_board, true_corners

from ..scenes import TRUTH, board


def seen_corners(params: np.ndarray, noise: float = 0.0) -> Corners:
    """The corners of a tilted board under (lam, cx, cy)."""
    places = np.stack(np.meshgrid(np.arange(10), np.arange(7)), axis=-1).reshape(-1, 2)
    homography = np.array([[44.0, 6.0, -190.0], [-3.0, 47.0, -140.0], [2e-2, 1e-2, 1.0]])
    points = see(params, homography, places)
    return Corners(points + np.random.default_rng(0).normal(0, noise, points.shape), places)


def test_see_is_the_models_distort() -> None:
    corners = seen_corners(TRUTH)
    model = DivisionModel(TRUTH[0], tuple(TRUTH[1:]), (640, 480))
    undistorted = model.undistort(corners.points) - TRUTH[1:]
    # A homography's columns stay in proportion: rows of the board are straight.
    rows = undistorted.reshape(7, 10, 2)
    steps = np.diff(rows, axis=1)
    cross = steps[:, :-1, 0] * steps[:, 1:, 1] - steps[:, :-1, 1] * steps[:, 1:, 0]
    np.testing.assert_allclose(cross, 0, atol=1e-8)


def test_the_linear_solution_is_exact_without_noise() -> None:
    lam, cx, cy = linear_solution(seen_corners(TRUTH))
    assert lam == pytest.approx(TRUTH[0], rel=1e-6)
    assert (cx, cy) == pytest.approx(tuple(TRUTH[1:]), abs=1e-4)


def test_the_fit_recovers_the_lens_from_noisy_corners() -> None:
    # 70 corners at 0.1 px, from a start that knows nothing.
    found = fit([seen_corners(TRUTH, 0.1)], np.array([0.0, 300.0, 250.0]))
    assert found.params[0] == pytest.approx(TRUTH[0], rel=0.03)
    assert np.hypot(*(found.params[1:] - TRUTH[1:])) < 3
    assert np.sqrt((found.residuals**2).mean()) < 0.11


def test_corners_elsewhere_than_the_others_have_them_are_dropped() -> None:
    seen = seen_corners(TRUTH, 0.1)
    wrong = seen.points.copy()
    wrong[[12, 40]] += [[1.5, 0.0], [0.0, -4.0]]
    corners = Corners(wrong, seen.places)
    kept = _without_outliers(corners, fit([corners], TRUTH))
    dropped = {*map(tuple, seen.places)} - {*map(tuple, kept.places)}
    assert dropped == {tuple(seen.places[12]), tuple(seen.places[40])}


@pytest.mark.parametrize("lam", [-2.4e-6, -5e-6, 0.0])
def test_every_corner_of_a_board_is_found_where_it_is(lam: float) -> None:
    scene = board(lam=lam)
    found = find_board(to_grey(render_board(scene)))
    assert found is not None
    truth, visible = true_corners(scene)
    away = np.linalg.norm(truth[visible][:, None] - found.corners.points, axis=-1)
    # Next to the frame's border a corner lacks the squares that would prove it.
    assert np.mean(away.min(axis=1) < 0.5) > 0.85
    assert np.all(away.min(axis=0) < 0.5)
    # And each is at its place: the grid differs by a turn and a shift only.
    nearest = away.argmin(axis=0)
    rows, columns = np.nonzero(visible)
    own = np.stack([columns, rows, np.ones_like(rows)], axis=1)[nearest].astype(float)
    turn, *_ = np.linalg.lstsq(own, found.corners.places.astype(float), rcond=None)
    np.testing.assert_allclose(own @ turn, found.corners.places, atol=1e-6)
    reach = 300.0
    assert found.fit.params[0] * reach**2 == pytest.approx(lam * reach**2, abs=0.01)


@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_a_board_does_not_grow_past_its_end(sample_data: Path, number: int) -> None:
    """14 x 11 squares, and a margin beside the rim of the view that looks like a corner here and there."""
    found = find_board(to_grey(read_image(sample_data / f"board-{number}.png")))
    assert found is not None
    assert sorted(np.ptp(found.corners.places, axis=0) + 1) == [10, 13]
    assert len(found.corners.points) == 130


def test_its_lines_run_along_rows_and_columns() -> None:
    scene = board()
    found = find_board(to_grey(render_board(scene)))
    assert found is not None
    columns, rows = np.ptp(found.corners.places, axis=0) + 1
    lines = found.lines()
    assert rows + columns - 4 <= len(lines) <= rows + columns
    for line in lines:
        bent = scene.model.undistort(line)
        singular = np.linalg.svd(bent - bent.mean(axis=0), compute_uv=False)
        assert singular[1] / np.sqrt(len(line)) < 0.5  # px


def test_nothing_is_found_where_no_board_is() -> None:
    assert find_board(to_grey(render_board(board(kind="lines")))) is None
    noise = np.random.default_rng(0).integers(0, 256, (240, 320)).astype(np.float32)
    assert find_board(noise) is None


@pytest.mark.parametrize("name", ["gopro3/3D_L0485.JPG", "endoscope_6080hd/6080HD.cal1000.png"])
def test_real_boards(real_data: Path, name: str) -> None:
    known = json.loads((real_data / "boards" / "corners.json").read_text())[name]
    expected = np.array(known["corners"]).reshape(-1, 2)
    found = find_board(fields(to_grey(read_image(real_data / "boards" / name)))[0])
    assert found is not None
    away = np.linalg.norm(expected[:, None] - found.corners.points, axis=-1)
    assert np.mean(away.min(axis=1) < 1.5) > 0.95
    assert np.all(away.min(axis=0) < 1.5)
