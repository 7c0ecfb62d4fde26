"""A regular grid's lines as two pencils."""

from __future__ import annotations

import numpy as np
import pytest

from endocal.calibration.board.pencils import Pencils, pencils_through

# From squares to px.
HOMOGRAPHY = np.array([[40.0, 6.0, -150.0], [-5.0, 35.0, -120.0], [1e-3, -8e-4, 1.0]])


def seen(families: np.ndarray, numbers: np.ndarray) -> np.ndarray:
    """The lines (n, 3), unit normals and minus the offsets, of rows (0) y = k and columns (1) x = k."""
    plane = np.zeros((len(families), 3))
    plane[np.arange(len(families)), 1 - families] = 1
    plane[:, 2] = -numbers
    lines = plane @ np.linalg.inv(HOMOGRAPHY)
    return lines / np.hypot(*lines.T[:2])[:, None]


def apart(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """How far two sets of lines differ, px at 300 px from the middle."""
    sign = np.sign(np.einsum("ni,ni->n", a[:, :2], b[:, :2]))[:, None]
    return np.abs((a - sign * b) * (300, 300, 1)).max(axis=1)


def found(
    families: np.ndarray, numbers: np.ndarray, flip: bool = False
) -> tuple[Pencils, np.ndarray]:
    lines = seen(families, numbers) * (-1 if flip else 1)
    placed = np.ones(len(lines), bool)
    grid, ways, same = pencils_through(lines, families, numbers.astype(float), placed, 300.0)
    assert same.tolist() == numbers.tolist()
    return grid, ways


@pytest.mark.parametrize("flip", [False, True])
def test_lines_of_a_grid_give_the_grid(flip: bool) -> None:
    families = np.repeat([0, 1], [7, 9])
    numbers = np.append(np.arange(-3, 4), np.arange(2, 11))
    grid, ways = found(families, numbers, flip)
    assert apart(grid.lines(families, numbers), seen(families, numbers)).max() < 1e-6
    assert ways.shape == (8, 9)
    np.testing.assert_allclose(ways @ grid.vector, 0, atol=1e-9)


def test_so_few_lines_tell_where_all_others_run() -> None:
    families, numbers = np.array([0, 0, 0, 1, 1, 1]), np.array([0, 2, 5, 1, 2, 7])
    grid, _ = found(families, numbers)
    others = np.repeat([0, 1], 9), np.tile(np.arange(9), 2)
    assert apart(grid.lines(*others), seen(*others)).max() < 1e-5


def test_lines_without_numbers_find_theirs() -> None:
    """Of the others only the family is known: then they are counted from the first."""
    families = np.array([0, 0, 0, 0, 1, 1, 1])
    numbers = np.array([1.0, 3, 4, 7, 2, 5, 6])
    lines = seen(families, numbers)
    told = np.where(families == 0, numbers, 0.0)
    grid, ways, found = pencils_through(lines, families, told, families == 0, 300.0)
    assert apart(grid.lines(families, found), lines).max() < 1e-5
    assert found[4] == 0
    # In steps of their own size: no one says how far a row is from the next.
    assert (found[6] - found[4]) / (found[5] - found[4]) == pytest.approx(4 / 3, rel=1e-6)
    assert ways.shape == (7, 9)


def test_places_have_the_numbers_of_the_lines_through_them() -> None:
    families, numbers = np.repeat([0, 1], 5), np.tile(np.arange(5), 2)
    grid, _ = found(families, numbers)
    x, y = np.array([0.5, 2.0, 3.25]), np.array([1.0, 2.5, 4.0])
    at = np.column_stack([x, y, np.ones(3)]) @ HOMOGRAPHY.T
    points = at[:, :2] / at[:, 2:]
    np.testing.assert_allclose(grid.numbers_at(points), y, atol=1e-6)
    np.testing.assert_allclose(grid.numbers_at(points, family=1), x, atol=1e-6)
