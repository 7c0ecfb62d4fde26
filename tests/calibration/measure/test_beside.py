"""A narrow strip's two edges draw each other off; put back they lie where they are."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ndtr

from endocal.calibration.measure.beside import put_back
from endocal.calibration.measure.profiles import Measured, measure, smoothed

# No distortion: what is straight in the picture are lines.
FLAT = np.array([0.0, 100.0, 100.0])
SIZE = 200
BLUR, SMOOTHED = 1.3, 1.2
# A step as measured: blurred, smoothed, and what differences and sampling add.
WIDTH = np.sqrt(BLUR**2 + SMOOTHED**2 + 2 / 3)


def strip(wide: float, far: float) -> tuple[np.ndarray, list[float]]:
    """A dark and a grey half, ``far`` of its contrast, a bright strip ``wide`` px between them, upright."""
    at = [100.3, 100.3 + wide]
    x = np.arange(SIZE)
    level = 40 + 120 * ndtr((x - at[0]) / BLUR) - far * 120 * ndtr((x - at[1]) / BLUR)
    return np.tile(level, (SIZE, 1)).astype(np.float32), at


def measured(wide: float, far: float) -> tuple[Measured, np.ndarray]:
    """Points of the strip's two edges, and how far to the right of them they lie, px."""
    grey, at = strip(wide, far)
    y = np.arange(20.0, SIZE - 20.0)
    points = np.concatenate([np.stack([np.full_like(y, x), y], axis=1) for x in at])
    found = measure(smoothed(grey), points, np.repeat([0, 1], len(y)), FLAT, follow=True)
    return found, found.points[:, 0] - np.array(at)[found.labels]


@pytest.mark.parametrize("far", [1.0, 0.4])
def test_the_edges_of_a_narrow_strip_are_put_back(far: float) -> None:
    found, off = measured(5.5, far)
    assert np.abs(off).max() > 0.09
    steep = np.sqrt(found.information)
    put, left = put_back(found, np.full(2, WIDTH), FLAT, steep, np.full(2, 5.5))
    assert list(left) == [0, 1]
    # Where the points of one edge stop, nothing tells that it goes on.
    inner = np.abs(put.points[:, 1] - SIZE / 2) < SIZE / 2 - 30
    now = put.points[inner, 0] - np.array([100.3, 105.8])[put.labels[inner]]
    assert np.abs(now).max() < 0.15 * np.abs(off).max()


def test_what_runs_far_from_others_stays() -> None:
    found, off = measured(25.0, 1.0)
    assert np.abs(off).max() < 0.02
    steep = np.sqrt(found.information)
    put, _ = put_back(found, np.full(2, WIDTH), FLAT, steep, np.full(2, 25.0))
    assert np.array_equal(put.points, found.points)


def test_points_drawn_off_far_are_left_out() -> None:
    found, _ = measured(3.0, 1.0)
    steep = np.sqrt(found.information)
    put, left = put_back(found, np.full(2, 2.8), FLAT, steep, np.full(2, 3.0))
    assert len(put.points) < len(found.points)
    assert len(left) == len(np.unique(put.labels))


@pytest.mark.parametrize("turned", [50.0, 60.0, 75.0])
def test_an_edge_that_crosses_draws_nothing_off(turned: float) -> None:
    """It meets the other at a corner, and does not run beside it."""
    upright, _ = measured(25.0, 1.0)
    upright = upright.take(upright.labels == 0)
    t, turn = np.arange(-60.0, 60.0), np.deg2rad(turned)
    points = np.stack([96.3 + np.sin(turn) * t, SIZE / 2 + np.cos(turn) * t], axis=1)
    n = len(points)
    steep = np.full(n, upright.information.mean())
    ones = np.ones(n)
    crossing = Measured(points, np.ones(n, np.intp), ones, np.full((n, 3), 100.0), steep)
    both = Measured.joined([upright, crossing], np.append(upright.labels, crossing.labels))
    put, _ = put_back(both, np.full(2, WIDTH), FLAT, np.sqrt(both.information), np.full(2, 5.0))
    np.testing.assert_allclose(put.points[put.labels == 0], upright.points, atol=0.02)
