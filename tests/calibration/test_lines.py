import numpy as np
import pytest

from endocal.calibration.edges import EdgePoints
from endocal.calibration.lines import LineSpec, group
from endocal.calibration.pattern import clear_of_corners, measured_once, merge_twins, on_board
from endocal.calibration.profiles import Measured

from .scenes import TRUTH, line_points

SPEC = LineSpec(distance=1.5, angle=np.deg2rad(6), points=40, span=40)


def test_each_line_is_found_and_clutter_is_left() -> None:
    points, labels, normals = line_points(TRUTH, count=12)
    rng = np.random.default_rng(2)
    turn = rng.uniform(0, 2 * np.pi, 600)
    clutter = rng.uniform((90, 10), (550, 470), (600, 2))
    edges = EdgePoints(
        np.vstack([points, clutter]),
        np.vstack([normals, np.stack([np.cos(turn), np.sin(turn)], axis=1)]),
    )
    found = group(edges, TRUTH, SPEC)
    assert found.count == 12
    own = found.labels[: len(points)]
    assert np.mean(own >= 0) > 0.97
    for label in range(12):
        kinds, counts = np.unique(own[labels == label], return_counts=True)
        assert counts.max() > 0.9 * counts.sum(), (label, kinds, counts)
    assert np.mean(found.labels[len(points) :] >= 0) < 0.1


def test_few_long_lines_have_less_entropy_than_many_short_ones() -> None:
    points, _, normals = line_points(TRUTH, count=12)
    edges = EdgePoints(points, normals)
    right, wrong = (group(edges, TRUTH * [f, 1, 1], SPEC).entropy() for f in (1.0, 0.3))
    # All points on twelve equal lines: ln 12.
    assert right == pytest.approx(np.log(12), abs=0.05)
    assert wrong > right + 0.2


def test_a_line_split_in_two_is_one_again() -> None:
    points, labels, _ = line_points(TRUTH, count=8)
    split = np.where((labels == 3) & (np.arange(len(labels)) % 2 == 0), 8, labels)
    merged = merge_twins(points, split, TRUTH, distance=1.0)
    assert len(np.unique(merged)) == 8
    assert len(np.unique(merged[labels == 3])) == 1


def grid(n: int, step: int = 20) -> Measured:
    """The lines of a flat n x n chessboard, one point a px, and one stray line that never changes sides."""
    t = np.arange(0.5, n * step)
    near = np.abs((t + step / 2) % step - step / 2) < 2  # too weak to be measured at crossings
    points, labels, sides = [], [], []
    for i in range(1, n):
        for flip in (0, 1):
            p = np.stack([t, np.full_like(t, i * step)], axis=1)[~near]
            points.append(p[:, ::-1] if flip else p)
            labels.append(np.full(len(p), len(labels)))
            sides.append(np.where((t[~near] // step + i) % 2 == 0, 1.0, -1.0))
    stray = np.stack([t, np.full_like(t, -50.0)], axis=1)
    points.append(stray)
    labels.append(np.full(len(stray), len(labels)))
    sides.append(np.ones(len(stray)))
    levels = np.tile([20.0, 200.0], (sum(map(len, points)), 1))
    return Measured(np.concatenate(points), np.concatenate(labels), np.concatenate(sides), levels)


def test_the_board_is_what_crossings_connect() -> None:
    measured = grid(8)
    board = on_board(measured)
    assert board is not None
    assert not board[measured.labels == measured.labels.max()].any()
    assert board[measured.labels < measured.labels.max()].all()


def test_no_board_among_lines_that_do_not_cross() -> None:
    measured = grid(8)
    across = measured.labels % 2 == 0
    assert on_board(measured.take(across)) is None
    assert on_board(Measured.none()) is None


def test_points_next_to_a_crossing_or_a_corner_are_left_out() -> None:
    """Runs are cut where their line goes on with the other side bright, and where they end."""
    measured = grid(8)
    assert clear_of_corners(measured, board=True)[measured.labels == measured.labels.max()].all()
    clear = clear_of_corners(measured, board=False)
    for line in range(4, 8):
        own = measured.labels == line
        axis = int(np.ptp(measured.points[own][:, 1]) > np.ptp(measured.points[own][:, 0]))
        along = measured.points[own][:, axis]
        from_corner = np.abs((along + 10) % 20 - 10)
        inner = (along > 10) & (along < 150)
        assert (from_corner[inner & clear[own]] > 4).all()
        assert not clear[own][along < along.min() + 4].any()
        assert np.count_nonzero(clear[own]) > 0.5 * np.count_nonzero(own)
    stray = clear[measured.labels == measured.labels.max()]
    assert stray[6:-6].all(), "it never changes sides"
    assert not stray[:4].any()
    assert clear_of_corners(Measured.none(), False).shape == (0,)


def test_the_ends_of_bars_are_told_by_their_middles() -> None:
    """A row of the ends of bars: edges with gaps between them, each of which turns a corner at both ends."""
    x = np.concatenate([np.arange(s, s + 20.0) for s in range(0, 200, 40)])
    row = Measured(
        np.stack([x, np.zeros_like(x)], axis=1),
        np.zeros(len(x), np.intp),
        np.ones(len(x)),
        np.tile([20.0, 200.0], (len(x), 1)),
    )
    kept = x[clear_of_corners(row, board=False)] % 40
    assert kept.min() >= 5
    assert kept.max() <= 14
    assert len(kept) == 5 * 10


def test_a_line_found_again_counts_once() -> None:
    measured = grid(8)
    own = np.flatnonzero(measured.labels == 4)
    again = own[len(own) // 4 : len(own) // 2]
    count = int(measured.labels.max()) + 1
    twice = Measured(
        np.concatenate([measured.points, measured.points[again] + 0.4]),
        np.concatenate([measured.labels, np.full(len(again), count)]),
        np.concatenate([measured.sides, measured.sides[again]]),
        np.concatenate([measured.levels, measured.levels[again]]),
    )
    once = measured_once(twice)
    assert once[: len(measured.points)].all(), "the longer line, and lines that only cross it, stay"
    assert not once[len(measured.points) :].any()
    assert measured_once(Measured.none()).shape == (0,)
