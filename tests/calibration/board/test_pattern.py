"""What of the measured lines is the pattern, where its corners are kept clear of, and what is found twice."""

from dataclasses import replace

import numpy as np

from endocal.calibration.board.pattern import (
    clear_of_crossings,
    measured_once,
    merge_twins,
    on_board,
)
from endocal.calibration.measure.profiles import Measured

from ..scenes import TRUTH, grid, line_points


def test_a_line_split_in_two_is_one_again() -> None:
    points, labels, _ = line_points(TRUTH, count=8)
    split = np.where((labels == 3) & (np.arange(len(labels)) % 2 == 0), 8, labels)
    merged = merge_twins(points, split, TRUTH, distance=1.0)
    assert len(np.unique(merged)) == 8
    assert len(np.unique(merged[labels == 3])) == 1


def test_the_board_is_what_crossings_connect() -> None:
    measured = grid(8)
    board = on_board(measured)
    assert board is not None
    assert not board[measured.labels == measured.labels.max()].any()
    assert board[measured.labels < measured.labels.max()].all()


def test_a_line_of_a_board_ends_a_square_beyond_its_last_crossing() -> None:
    """Or a little farther, as perspective has it: what goes on is the sheet's edge, or the table's."""
    measured = grid(8)
    last = measured.points[measured.labels == 4].max(axis=0)
    axis = int(last.argmax())
    more = np.tile(last, (60, 1))
    more[:, axis] += np.arange(1, 61)
    part = measured.in_order(np.full(60, np.flatnonzero(measured.labels == 4)[-1]), np.full(60, 4))
    longer = Measured.joined(
        [measured, replace(part, points=more)], np.append(measured.labels, part.labels)
    )
    order = np.argsort(longer.labels, kind="stable")
    board = on_board(longer.in_order(order, longer.labels[order]))
    assert board is not None
    # Its square is 20 px long, counted from where it is measured again: of 60 px more it has 8 to 13.
    kept = np.count_nonzero(board[longer.labels[order] == 4])
    assert 8 <= kept - np.count_nonzero(measured.labels == 4) <= 13


def test_no_board_among_lines_that_do_not_cross() -> None:
    measured = grid(8)
    across = measured.labels % 2 == 0
    assert on_board(measured.take(across)) is None
    assert on_board(Measured.none()) is None


def test_points_next_to_a_crossing_are_left_out() -> None:
    """Runs are cut where their line goes on with the other side bright, and not where they end."""
    measured = grid(8)
    clear = clear_of_crossings(measured)
    assert clear[measured.labels == measured.labels.max()].all(), "it never changes sides"
    for line in range(4, 8):
        own = measured.labels == line
        axis = int(np.ptp(measured.points[own][:, 1]) > np.ptp(measured.points[own][:, 0]))
        along = measured.points[own][:, axis]
        from_corner = np.abs((along + 10) % 20 - 10)
        inner = (along > 10) & (along < 150)
        assert (from_corner[inner & clear[own]] > 4).all()
        assert np.count_nonzero(clear[own]) > 0.5 * np.count_nonzero(own)
    assert clear_of_crossings(Measured.none()).shape == (0,)


def test_a_line_found_again_counts_once() -> None:
    measured = grid(8)
    own = np.flatnonzero(measured.labels == 4)
    again = own[len(own) // 4 : len(own) // 2]
    count = int(measured.labels.max()) + 1
    part = measured.in_order(again, np.full(len(again), count))
    part = replace(part, points=part.points + 0.4)
    twice = Measured.joined([measured, part], np.concatenate([measured.labels, part.labels]))
    once = measured_once(twice)
    assert once[: len(measured.points)].all(), "the longer line, and lines that only cross it, stay"
    assert not once[len(measured.points) :].any()
    assert measured_once(Measured.none()).shape == (0,)


def test_a_line_that_for_a_part_is_another_one_is_none_of_its_own() -> None:
    measured = grid(8)
    own = np.flatnonzero(measured.labels == 4)[:60]
    count = int(measured.labels.max()) + 1
    part = measured.in_order(own, np.full(60, count))
    # It leaves the other after 24 points, at an angle.
    axis = int(np.ptp(part.points[:, 1]) < np.ptp(part.points[:, 0]))
    points = part.points.copy()
    points[24:, axis] += 5 + 0.2 * np.arange(36)
    both = Measured.joined(
        [measured, replace(part, points=points)], np.append(measured.labels, part.labels)
    )
    once = measured_once(both)
    assert once[: len(measured.points)].all()
    assert not once[len(measured.points) :].any()
