"""Parallel bars: edges find their numbers, and rows of ends are told from other lines."""

from __future__ import annotations

import numpy as np
import pytest

from endocal.calibration.board.bars import bars_of
from endocal.calibration.board.numbered import numbered_lines
from endocal.calibration.measure.profiles import Measured

from ..scenes import grid
from ..sheets import COLUMNS, LENS, ROWS, bars, board, sheet

EDGES = COLUMNS + 1


def with_line(m: Measured, x: np.ndarray, y: np.ndarray, side: float = 1.0) -> Measured:
    """One line more, through places on the sheet, bright to the left or right of its way."""
    points = sheet(x, y)
    n = len(points)
    sides = np.full(n, side)
    more = Measured(points, np.zeros(n, np.intp), sides, np.full((n, 3), 100.0), np.ones(n))
    return Measured.joined([m, more], np.append(m.labels, np.full(n, m.labels.max() + 1)))


def steps(numbers: np.ndarray) -> list[int]:
    return np.abs(np.diff(numbers)).tolist()


def test_all_edges_have_their_numbers() -> None:
    found = bars_of(bars(), LENS)
    assert found is not None
    assert sorted(found.edges.tolist()) == list(range(EDGES))
    assert steps(found.numbers[np.argsort(found.edges)]) == [1] * (EDGES - 1)
    assert found.rows.tolist() == [EDGES, EDGES + 1]


@pytest.mark.parametrize("missing", [(4,), (3, 4), (2, 7), (5, 6, 7)])
def test_what_is_missed_is_counted(missing: tuple[int, ...]) -> None:
    found = bars_of(bars(missing=missing), LENS)
    assert found is not None
    there = [k for k in range(EDGES) if k not in missing]
    order = np.argsort(found.edges)
    assert len(found.edges) == len(there)
    assert steps(found.numbers[order]) == np.diff(there).tolist()


def test_a_poor_model_numbers_them_too() -> None:
    found = bars_of(bars(noise=0.3), np.array([0.0, 319.5, 239.5]))
    assert found is not None
    assert steps(found.numbers[np.argsort(found.edges)]) == [1] * (EDGES - 1)


def test_a_line_across_bars_and_gaps_is_no_row_of_ends() -> None:
    x = np.linspace(-COLUMNS / 2, COLUMNS / 2, 300)
    found = bars_of(with_line(bars(), x, np.full(300, -ROWS / 2 - 0.7)), LENS)
    assert found is not None
    assert found.rows.tolist() == [EDGES, EDGES + 1]


@pytest.mark.parametrize("away", [0.6, 1.4])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_sheet_s_side_at_a_distance_of_its_own_has_no_number(away: float, side: float) -> None:
    y = np.linspace(-ROWS / 2, ROWS / 2, 300)
    found = bars_of(with_line(bars(), np.full(300, -COLUMNS / 2 - away), y, side), LENS)
    assert found is not None
    assert sorted(found.edges.tolist()) == list(range(EDGES))


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_line_askew_in_the_place_of_an_edge_has_no_number(side: float) -> None:
    """By three degrees: through the middle of a place that is free, but not to the bars' vanishing point."""
    y = np.linspace(-ROWS / 2, ROWS / 2, 300)
    x = -COLUMNS / 2 - 1 + np.tan(np.deg2rad(3)) * y
    found = bars_of(with_line(bars(), x, y, side), LENS)
    assert found is not None
    assert sorted(found.edges.tolist()) == list(range(EDGES))


def test_a_few_regular_lines_among_others_are_no_bars() -> None:
    """Seven follow each other at one distance; eight more, as parallel, do so at none."""
    m = bars()
    m = m.take(m.labels < 7)
    y = np.linspace(-ROWS / 2, ROWS / 2, 300)
    assert bars_of(m, LENS) is not None
    for k, x in enumerate((2.3, 2.62, 3.37, 3.6, 4.45, 4.71, 5.2, 5.88)):
        m = with_line(m, np.full(300, x), y, (-1.0) ** k)
    assert bars_of(m, LENS) is None


def test_rows_run_across_and_have_no_numbers() -> None:
    m = bars()
    lines = numbered_lines(m, np.zeros(len(m.points), np.intp), LENS)
    assert np.count_nonzero(lines.placed) == EDGES
    assert lines.family[lines.placed].max() == 0
    assert lines.family[~lines.placed].tolist() == [1, 1]


def test_a_chessboard_or_nothing_is_no_bars() -> None:
    assert bars_of(Measured.none(), LENS) is None
    assert bars_of(grid(4), LENS) is None
    m = board()
    assert numbered_lines(m, np.zeros(len(m.points), np.intp), LENS).placed.all()
