"""Starts are compared on a few of the points: of many pictures, too, enough for every line."""

import numpy as np
import pytest

from endocal.calibration.fit.plumb_line import Prior
from endocal.calibration.fit.refine import best_start
from endocal.calibration.fit.view import View
from endocal.calibration.image.edges import EdgePoints

CENTER = (200.0, 150.0)


def dense_board() -> View:
    """Eighteen lines each way, 300 points of each, as a lens shows them that bends nothing."""
    t, at = np.linspace(-140, 140, 300), np.linspace(-140, 140, 18)
    level = np.stack([np.tile(t, 18), np.repeat(at, 300)], axis=1)
    points = np.concatenate([level, level[:, ::-1]]) + CENTER
    gradients = np.repeat([[0.0, 1.0], [1.0, 0.0]], len(level), axis=0)
    return View(np.zeros((300, 400), np.float32), EdgePoints(points, gradients))


@pytest.mark.parametrize("pictures", [1, 20])
def test_the_lines_of_all_pictures_are_found(pictures: int) -> None:
    found = np.array([1e-9, *CENTER])
    start = best_start([dense_board()] * pictures, found, 200.0, Prior(CENTER, (20.0, 15.0)))
    assert start is not None
    assert start[0] * 200.0**2 == pytest.approx(0, abs=1e-3)
