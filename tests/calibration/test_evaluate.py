"""The two measures of straightness, against truth and against each other."""

import math

import numpy as np
import pytest

from endocal.calibration.evaluate import LinePoints, evaluate
from endocal.model import DivisionModel

from .scenes import TRUTH, line_points

MODEL = DivisionModel(TRUTH[0], tuple(TRUTH[1:]), (640, 480))


def exact(noise: float = 0.0) -> LinePoints:
    points, labels, _ = line_points(TRUTH)
    return LinePoints(points + np.random.default_rng(0).normal(0, noise, points.shape), labels)


def test_the_true_model_makes_exact_lines_straight() -> None:
    found = evaluate(exact(), MODEL)
    assert found.rmse == pytest.approx(0, abs=1e-9)
    assert found.straightness == pytest.approx(0, abs=1e-5)
    assert found.rmse_before > 3
    assert found.lines == 14
    assert found.points == 14 * 120


def test_rmse_is_total_least_squares_line_by_line() -> None:
    lines = exact(0.3)
    squares = 0.0
    for i in range(lines.count):
        u = MODEL.undistort(lines.points[lines.labels == i])
        squares += np.linalg.svd(u - u.mean(axis=0), compute_uv=False)[1] ** 2
    expected = math.sqrt(squares / len(lines.points))
    assert evaluate(lines, MODEL).rmse == pytest.approx(expected, rel=1e-9)


def test_magnification_moves_one_and_not_the_other() -> None:
    # Noise of 0.3 px: what is left of it across a line once the line is fitted.
    found = evaluate(exact(0.3), MODEL)
    assert found.straightness == pytest.approx(0.3, rel=0.05)
    # Undistorted px are larger ones where the lens bends much.
    assert found.rmse > 1.2 * found.straightness


def test_a_model_that_folds_before_a_point_is_infinitely_wrong() -> None:
    found = evaluate(exact(), DivisionModel(-2e-5, tuple(TRUTH[1:]), (640, 480)))
    assert found.rmse == found.straightness == math.inf
    assert math.isfinite(found.rmse_before)


def test_pixels_that_are_not_square() -> None:
    lines = exact(0.2)
    aspect = 1.25
    squeezed = LinePoints(lines.points / (aspect, 1), lines.labels)
    model = DivisionModel(TRUTH[0], (TRUTH[1] / aspect, TRUTH[2]), (512, 480), aspect)
    found, expected = evaluate(squeezed, model), evaluate(lines, MODEL)
    assert found.rmse == pytest.approx(expected.rmse, rel=1e-9)
    assert found.straightness == pytest.approx(expected.straightness, rel=1e-9)
