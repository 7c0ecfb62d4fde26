"""The farthest corners of several looks at one board."""

from __future__ import annotations

import numpy as np
import pytest

from endocal.calibration.board.lifted import Corners
from endocal.calibration.board.union import united

ROWS, COLS = 6, 8
CENTER = np.array([100.0, 80.0])
# The place that is seen farthest from there.
FARTHEST = (5, 7)


def look(missing: tuple[tuple[int, int], ...] = (), moved: float = 0.0) -> Corners:
    """A bent board's corners but the ``missing`` places, found ``moved`` px aside."""
    places = np.array(
        [(i, j) for i in range(ROWS) for j in range(COLS) if (i, j) not in missing], np.intp
    )
    i, j = places.T
    points = np.stack([40.0 * j + 0.5 * i * j, 40.0 * i - 0.3 * j**2], axis=1)
    return Corners(points + moved, places)


def renumbered(corners: Corners, turn: list[list[int]], shift: tuple[int, int]) -> Corners:
    return Corners(corners.points, corners.places @ np.array(turn) + shift)


def by_place(corners: Corners) -> dict[tuple[int, int], tuple[float, float]]:
    assert len(np.unique(corners.places, axis=0)) == len(corners.places)
    return {
        (int(i), int(j)): (float(x), float(y))
        for (i, j), (x, y) in zip(corners.places, corners.points, strict=True)
    }


TURNS = {
    "as they are": [[1, 0], [0, 1]],
    "rows are columns": [[0, 1], [1, 0]],
    "columns from the other end": [[1, 0], [0, -1]],
    "turned by a quarter": [[0, -1], [1, 0]],
}


@pytest.mark.parametrize("turn", list(TURNS.values()), ids=list(TURNS))
def test_a_farther_corner_is_added_and_a_nearer_one_is_not(turn: list[list[int]]) -> None:
    row = tuple((0, j) for j in range(COLS))
    first, second = look(missing=(FARTHEST, (2, 3))), look(missing=row, moved=0.3)
    whole = united([first, look(missing=row), renumbered(second, turn, (4, -7))], CENTER)
    expected = by_place(look(missing=((2, 3),)))
    assert by_place(whole) == expected
    other = united([first, renumbered(second, turn, (4, -7))], CENTER)
    assert by_place(other) == {**expected, FARTHEST: by_place(second)[FARTHEST]}


def test_one_look_is_itself() -> None:
    only = look()
    assert united([only], CENTER) is only


def test_another_board_adds_nothing() -> None:
    first = look(missing=(FARTHEST,))
    elsewhere = look(moved=20.0)
    few = Corners(look().points[:8], look().places[:8])
    nothing = Corners(np.empty((0, 2)), np.empty((0, 2), np.intp))
    for other in (elsewhere, few, nothing):
        assert by_place(united([first, other], CENTER)) == by_place(first)
    assert len(united([nothing, first], CENTER).points) == 0


def test_a_look_that_numbers_otherwise_adds_nothing() -> None:
    """Half of its rows are one off: it took one row for two."""
    first, second = look(missing=(FARTHEST,)), look()
    torn = Corners(second.points, second.places + (second.places[:, :1] > 2))
    assert by_place(united([first, torn], CENTER)) == by_place(first)


def test_a_place_that_is_taken_stays() -> None:
    """A corner that another look puts elsewhere is not added beside the first one."""
    first = look()
    points = first.points.copy()
    points[-1] += 15.0
    assert tuple(first.places[-1]) == FARTHEST
    assert by_place(united([first, Corners(points, first.places)], CENTER)) == by_place(first)
