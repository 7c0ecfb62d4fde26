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


def with_line(m: Measured, x: np.ndarray, y: np.ndarray) -> Measured:
    """One line more, through places on the sheet."""
    points = sheet(x, y)
    n = len(points)
    more = Measured(points, np.zeros(n, np.intp), np.ones(n), np.full((n, 2), 100.0), np.ones(n))
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


def test_a_sheet_s_side_at_a_distance_of_its_own_has_no_number() -> None:
    y = np.linspace(-ROWS / 2, ROWS / 2, 300)
    found = bars_of(with_line(bars(), np.full(300, -COLUMNS / 2 - 0.6), y), LENS)
    assert found is not None
    assert sorted(found.edges.tolist()) == list(range(EDGES))


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
