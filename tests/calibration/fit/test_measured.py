"""Lines of too few points have no say: what is fitted to each takes all that they tell."""

from __future__ import annotations

import numpy as np

from endocal.calibration.fit.measured import telling
from endocal.calibration.measure.profiles import Measured


def lines_of(*counts: int) -> Measured:
    """Level lines, one below the other, of so many points a px apart."""
    labels = np.repeat(np.arange(len(counts)), counts)
    points = np.stack([np.concatenate([np.arange(n) for n in counts]), 9.0 * labels], axis=1)
    one = np.ones(len(labels))
    return Measured(points, labels, one, np.outer(one, [20.0, 200.0, 200.0]), one)


def test_a_line_of_a_few_points_is_left_out() -> None:
    measured = lines_of(100, 1, 6, 7, 50)
    assert np.unique(measured.labels[telling(measured)]).tolist() == [0, 3, 4]


def test_no_points_are_no_lines() -> None:
    assert len(telling(Measured.none())) == 0


def test_a_thinned_line_of_which_next_to_nothing_remains_is_left_out() -> None:
    whole = lines_of(200, 20, 200)
    thin = whole.thinned(len(whole.points) // 10)
    assert np.bincount(thin.labels).tolist() == [20, 20]
    assert np.unique(thin.points[:, 1]).tolist() == [0.0, 18.0]


def test_of_more_lines_than_can_be_thinned_all_points_stay() -> None:
    whole = lines_of(*[20] * 300)
    assert whole.thinned(600) is whole
