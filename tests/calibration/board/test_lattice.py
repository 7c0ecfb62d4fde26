"""Pieces of a board's lines find each other by the corners they share."""

from __future__ import annotations

import numpy as np
import pytest

from endocal.calibration.board.lattice import Crossings, places_of
from endocal.calibration.board.pattern import join_pieces
from endocal.calibration.measure.profiles import Measured

from ..scenes import grid


def cut(measured: Measured, line: int, at: float, lap: float = 0.0) -> Measured:
    """Give the part of a line beyond ``at`` px along it a label of its own; ``lap`` px belong to both."""
    own = measured.points[measured.labels == line]
    axis = int(np.ptp(own[:, 1]) > np.ptp(own[:, 0]))
    new = int(measured.labels.max()) + 1
    beyond = (measured.labels == line) & (measured.points[:, axis] > at)
    labels = np.where(beyond, new, measured.labels)
    both = (measured.labels == line) & beyond & (measured.points[:, axis] < at + lap)
    labels = np.concatenate([labels, measured.labels[both]])
    pieces = Measured.joined([measured, measured.take(both)], labels)
    points = pieces.points
    along = np.where(np.isin(labels, (line, new)), points[:, axis], np.arange(len(points)))
    order = np.lexsort((along, labels))
    return pieces.in_order(order, labels[order])


def labels_of(measured: Measured, whole: Measured, line: int) -> set[int]:
    """The labels that the points of a whole line have now."""
    own = {tuple(p) for p in whole.points[whole.labels == line]}
    return {
        int(i) for p, i in zip(measured.points, measured.labels, strict=True) if tuple(p) in own
    }


@pytest.mark.parametrize("lap", [0.0, 60.0], ids=["end to end", "over each other"])
@pytest.mark.parametrize("line", [4, 7])
def test_two_pieces_of_one_line_become_one(line: int, lap: float) -> None:
    whole = grid(8)
    pieces = cut(whole, line, 130.0, lap)
    assert len(labels_of(pieces, whole, line)) == 2
    joined = join_pieces(pieces)
    assert len(labels_of(joined, whole, line)) == 1
    assert joined.labels.max() == whole.labels.max()
    # Whoever walks along the line meets its points in order.
    axis = int(np.ptp(joined.points[joined.labels == line][:, 1]) > 10)
    steps = np.diff(joined.points[joined.labels == line][:, axis])
    assert (steps >= 0).all() or (steps <= 0).all()


def test_whole_lines_are_left_as_they_are() -> None:
    whole = grid(8)
    assert join_pieces(whole) is whole
    assert join_pieces(Measured.none()).points.shape == (0, 2)


def test_a_neighbouring_line_is_no_piece() -> None:
    """Two half lines of different rows, which a gap lets look like one, stay apart."""
    whole = grid(8)
    low, high = 4, 6  # lines next to each other, both along the same axis
    keep = np.ones(len(whole.points), bool)
    own = whole.points[whole.labels == low]
    axis = int(np.ptp(own[:, 1]) > np.ptp(own[:, 0]))
    keep &= ~((whole.labels == low) & (whole.points[:, axis] > 130))
    keep &= ~((whole.labels == high) & (whole.points[:, axis] < 130))
    halves = whole.take(keep)
    assert join_pieces(halves) is halves


def test_lines_that_go_on_into_something_else_number_nothing_wrongly() -> None:
    """Three rows that meet beyond the board seem to cross each other, and so have the most crossings."""
    rows, columns, beyond = range(5), range(5, 10), (0, 2, 4)
    crossings = [(a, b, 0, 0, 1, (0.0, 20.0)) for a in beyond for b in beyond if a < b]
    crossings += [(r, c, c - 4, r, 1, (10.0 * c, 10.0 * r)) for r in rows for c in columns]
    a, b, i, j, turn, places = (np.array(v) for v in zip(*crossings, strict=True))
    known = Crossings(np.stack([a, b], axis=1), np.stack([i, j], axis=1), turn, places)
    at, numbered = places_of(known)
    assert numbered[3:].all()
    at = at[3:].reshape(5, 5, 2)
    # Rows and columns, each with numbers of its own, one apart.
    for axis, family in ((0, at[:, 0]), (1, at[0, :])):
        steps = np.abs(np.diff(family, axis=0)).sum(axis=1)
        assert (steps == 1).all(), axis
