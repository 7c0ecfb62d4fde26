"""Rows of bars' ends are told by where the bars' edges end."""

from dataclasses import replace

import numpy as np

from endocal.calibration.fit.end_rows import FEWEST_ENDS, end_rows, new_lines
from endocal.calibration.image.edges import EdgePoints
from endocal.calibration.measure.profiles import Measured
from endocal.model import DivisionModel

MODEL = DivisionModel(-2.4e-6, (319.5, 239.5), (640, 480))
PARAMS = np.array([MODEL.lam, *MODEL.center])


def bars(count: int, ends: float = 100.0, slant: float = 0.2) -> tuple[EdgePoints, Measured]:
    """Upright bars 8 px wide, which end on a slanted row ``ends`` px down at the left, seen by a lens.

    Their sides are measured up to 4 px before the ends. The edge points are the rounded ends alone.
    """
    turn = np.linspace(0, np.pi, 15)
    sides, rounded, labels = [], [], []
    for bar in range(count):
        left = 150.0 + 20 * bar
        top = ends + slant * left
        for side in (0.0, 8.0):
            y = np.arange(top + 4, 420.0)
            sides.append(np.stack([np.full_like(y, left + side), y], axis=1))
            labels.append(np.full(len(y), len(labels), np.intp))
        rounded.append(np.stack([left + 4 - 4 * np.cos(turn), top + 4 - 4 * np.sin(turn)], axis=1))
    points = MODEL.distort(np.concatenate(sides))
    number = np.concatenate(labels)
    ones = np.ones(len(points))
    measured = Measured(points, number, ones, np.zeros((len(points), 3)), ones)
    seen = MODEL.distort(np.concatenate(rounded))
    return EdgePoints(seen, np.tile([0.0, 1.0], (len(seen), 1))), measured


def test_the_row_of_narrow_rounded_ends_is_found() -> None:
    edges, lines = bars(12)
    points, labels = end_rows(edges, lines, PARAMS)
    assert list(np.unique(labels)) == [0]
    assert len(points) > 12
    plane = MODEL.undistort(points)
    off = plane[:, 1] - 0.2 * plane[:, 0] - 100.0
    assert np.ptp(off) < 1.5
    assert np.abs(off).max() < 3


def test_ends_beside_the_row_are_not_on_it() -> None:
    """Every sixth bar ends 5 px higher than the row of the others."""
    edges, lines = bars(12)
    higher = np.arange(12) % 6 == 1
    moved = edges.points - np.stack([np.zeros(len(edges)), 5.0 * np.repeat(higher, 15)], axis=1)
    points, labels = end_rows(EdgePoints(moved, edges.gradients), lines, PARAMS)
    assert list(np.unique(labels)) == [0]
    assert len(points) == 20
    plane = MODEL.undistort(points)
    assert np.ptp(plane[:, 1] - 0.2 * plane[:, 0]) < 1.5


def test_a_line_measured_again_is_no_new_row() -> None:
    _, lines = bars(3)
    again = lines.take(lines.labels == 2)
    row = replace(
        again, points=again.points + np.array([60.0, 0.0]), labels=np.ones_like(again.labels)
    )
    rows = Measured.joined([again, row], np.append(0 * again.labels, row.labels))
    assert new_lines(rows, lines).tolist() == [1]


def test_few_ends_are_no_row() -> None:
    edges, lines = bars(FEWEST_ENDS // 2 - 1)
    assert len(end_rows(edges, lines, PARAMS)[0]) == 0


def test_ends_here_and_there_are_no_row() -> None:
    edges, lines = bars(9)
    jump = np.random.default_rng(2).uniform(-40, 40, lines.labels.max() // 2 + 1)
    moved = edges.points + np.stack([np.zeros(len(edges)), np.repeat(jump, 15)], axis=1)
    near = lines.points[:, 1] > 160
    assert len(end_rows(EdgePoints(moved, edges.gradients), lines.take(near), PARAMS)[0]) == 0


def test_nothing_seen_is_no_row() -> None:
    edges, lines = bars(9)
    assert len(end_rows(EdgePoints.none(), lines, PARAMS)[0]) == 0
    assert len(end_rows(edges, Measured.none(), PARAMS)[0]) == 0
