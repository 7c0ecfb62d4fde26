"""The straightness of corners: on grids whose bend is known, and against the real pictures' own figures."""

from __future__ import annotations

import json
import math
from pathlib import Path

import cv2
import numpy as np
import pytest

from endocal.benchmarks.corner_score import as_grid, find_corners, mean_spacing, straightness
from endocal.model import DivisionModel

MODEL = DivisionModel(-2e-6, (310.0, 250.0), (640, 480))


def grid(rows: int = 7, cols: int = 9, spacing: float = 40.0) -> np.ndarray:
    x, y = np.meshgrid(np.arange(cols) - (cols - 1) / 2, np.arange(rows) - (rows - 1) / 2)
    flat = np.stack([x, y, 0.08 * x / cols + 0.05 * y / rows + 1], axis=-1)
    turn = np.array([[0.96, -0.28], [0.28, 0.96]])
    return (flat[..., :2] / flat[..., 2:]) @ turn.T * spacing + (320, 240)


def test_the_true_model_makes_distorted_lines_straight() -> None:
    corners = MODEL.distort(grid())
    assert straightness(corners) > 1
    assert straightness(corners, MODEL) == pytest.approx(0, abs=1e-9)


def test_one_corner_off_its_line_counts_as_it_should() -> None:
    corners = np.stack(np.meshgrid(np.arange(9) * 40.0, np.arange(7) * 40.0), axis=-1)
    corners[3, 4, 1] += (
        0.7  # in the middle of a row of 9 and of a column of 7; along the column it is no error
    )
    row = 0.7**2 * (1 - 1 / 9)
    assert straightness(corners) == pytest.approx(math.sqrt(row / (2 * 63)), rel=1e-3)


def test_a_model_that_only_shrinks_the_picture_gains_nothing() -> None:
    # Corners near the centre see little but a scale in the corrected picture; the score takes it out again.
    noise = np.random.default_rng(0).normal(0, 0.3, (7, 9, 2))
    corners = grid(spacing=4.0) + noise
    far = DivisionModel(-1e-7, (320.0, 240.0), (640, 480))
    shrinking = DivisionModel(+3.7e-5, (320.0, 240.0 - 90), (640, 480))
    assert straightness(corners, far) == pytest.approx(straightness(corners), rel=0.01)
    assert mean_spacing(shrinking.undistort(corners)) < 0.8 * mean_spacing(corners)
    assert straightness(corners, shrinking) > 0.8 * straightness(corners)


def test_a_corner_past_the_fold_is_infinitely_bad() -> None:
    folding = DivisionModel(-1 / 100**2, (320.0, 240.0), (640, 480))
    assert straightness(grid(), folding) == math.inf


@pytest.mark.parametrize("counts", [(7, 9), (9, 7)])
@pytest.mark.parametrize("transposed", [False, True])
def test_neighbours_tell_the_order_of_a_grid(counts: tuple[int, int], transposed: bool) -> None:
    corners = grid().swapaxes(0, 1) if transposed else grid()
    assert np.array_equal(as_grid(corners.reshape(-1, 2), counts), corners)


def test_corners_are_found_without_the_size_of_the_board(sample_data: Path) -> None:
    picture = cv2.imread(str(sample_data / "board-4.png"), cv2.IMREAD_GRAYSCALE)
    corners = find_corners(picture)
    assert corners is not None
    assert min(corners.shape[:2]) >= 5
    assert straightness(corners) > 1
    assert find_corners(np.full((200, 200), 90, np.uint8)) is None


def test_the_scores_are_those_of_the_real_pictures(real_data: Path) -> None:
    known = json.loads((real_data / "boards" / "corners.json").read_text())
    assert known
    for name, entry in known.items():
        corners = as_grid(np.array(entry["corners"]).reshape(-1, 2), tuple(entry["grid"]))
        best = DivisionModel(
            entry["floor_lambda"], tuple(entry["floor_center"]), tuple(entry["size"])
        )
        # Printed to 3 digits; lambda and the centre of the best model are rounded, too.
        assert straightness(corners) == pytest.approx(entry["rms_uncorrected"], abs=6e-4), name
        assert straightness(corners, best) == pytest.approx(entry["floor_division"], abs=2e-3), name
