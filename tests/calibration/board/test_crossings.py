"""Corners where measured lines cross, to a hundredth of a pixel."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from endocal.calibration.board.crossings import corners_of
from endocal.calibration.board.pattern import clear_of_crossings
from endocal.calibration.measure.profiles import Measured

from ..scenes import grid


def bent(measured: Measured, growth: float = 0.0) -> Measured:
    """The lines of a flat board through a smooth map; bright areas ``growth`` px larger on each side."""
    x, y = measured.points.T
    down = np.array(
        [np.ptp(y[measured.labels == i]) > np.ptp(x[measured.labels == i]) for i in range(15)]
    )
    normal = np.where(down[measured.labels][:, None], (1.0, 0.0), (0.0, 1.0))
    points = measured.points + growth * measured.sides[:, None] * normal
    return replace(measured, points=curved(points))


def curved(points: np.ndarray) -> np.ndarray:
    """A map that bends lines by some px over the board."""
    x, y = points.T / 100
    return 100 * np.stack([x + 0.03 * x * y + 0.02 * y**2, y - 0.03 * x**2 + 0.01 * y * x], axis=1)


def places_and_errors(measured: Measured) -> tuple[np.ndarray, np.ndarray]:
    """The places of the corners found, and how far each lies from the nearest true one, px."""
    found = corners_of(measured.take(clear_of_crossings(measured)))
    i, j = np.meshgrid(20.0 * np.arange(1, 8), 20.0 * np.arange(1, 8))
    true = curved(np.stack([i, j], axis=-1).reshape(-1, 2))
    away = np.linalg.norm(found.points[:, None] - true, axis=2)
    assert len(set(away.argmin(axis=1).tolist())) == len(found.points)
    return found.places, away.min(axis=1)


def test_corners_are_where_bent_lines_meet() -> None:
    places, errors = places_and_errors(bent(grid(8)))
    assert len(places) == 49
    # What a parabola leaves of these curves over a square.
    assert errors.max() < 0.01
    assert np.ptp(places, axis=0).tolist() == [6, 6]
    assert len(np.unique(places, axis=0)) == 49


def test_bright_squares_that_grow_move_no_corner() -> None:
    _, errors = places_and_errors(bent(grid(8), growth=0.4))
    # The two lines' own growth bends with the map: 3 % of it.
    assert errors.max() < 0.03


def test_no_board_no_corner() -> None:
    assert corners_of(Measured.none()).points.shape == (0, 2)
    whole = grid(8)
    rows = whole.take(whole.labels % 2 == 0)
    assert len(corners_of(rows).points) == 0
