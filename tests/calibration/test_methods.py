"""The article's other measures, each against the plainest loop over its formulas, and all near the truth."""

import numpy as np
import pytest

from endocal import CalibrationSpec, calibrate
from endocal.calibration.measures import MEASURES
from endocal.calibration.methods.cht import face_cells, face_points
from endocal.calibration.methods.entropy import entropy
from endocal.calibration.methods.heplp import SecondMap
from endocal.calibration.methods.hewog import vote_map
from endocal.calibration.methods.tangents import Tangents
from endocal.model import DivisionModel
from endocal.synth.board import render_board

from .scenes import TRUTH, board, line_points


def test_entropy_is_that_of_eq_6() -> None:
    votes = np.array([[3, 0], [1, 4]])
    p = np.array([3, 1, 4]) / 8
    assert entropy(votes) == pytest.approx(-(p * np.log(p)).sum())
    # Two more points, each in a cell of its own.
    p = np.array([3, 1, 4, 1, 1]) / 10
    assert entropy(votes, alone=2) == pytest.approx(-(p * np.log(p)).sum())
    assert entropy(np.zeros(4)) == 0


def test_hewog_is_a_plain_hough_transform() -> None:
    rng = np.random.default_rng(0)
    points = rng.uniform(-20, 20, (60, 2))
    angles, step, half = 24, 2.0, 8
    expected = np.zeros((angles, 2 * half), int)
    for x, y in points:
        for i in range(angles):
            t = (i + 0.5) * np.pi / angles
            j = int(np.floor((x * np.cos(t) + y * np.sin(t)) / step)) + half
            if 0 <= j < 2 * half:
                expected[i, j] += 1
    np.testing.assert_array_equal(vote_map(points, angles, step, half), expected)


def test_heplps_second_map_is_that_of_eq_10_to_14() -> None:
    rng = np.random.default_rng(1)
    theta, r = rng.uniform(0, np.pi, 40), rng.uniform(-300, 300, 40)
    votes = rng.integers(1, 9, 40)
    q, directions = (319.5, 239.5), 30
    expected = np.zeros((directions, directions))
    for t, offset, count in zip(theta, r, votes, strict=True):
        for i in range(directions):
            w = i * np.pi / directions
            # M goes through P, the origin: r_w = 0. V = M x L, and n = Q x V.
            v = np.cross([np.cos(w), np.sin(w), 0.0], [np.cos(t), np.sin(t), -offset])
            n = np.cross([*q, 1.0], v)
            rho = np.arctan2(n[0], n[1]) % np.pi
            expected[i, int(rho / np.pi * directions) % directions] += count
    found = SecondMap(q, directions, directions).votes(theta, r, votes)
    # Single precision moves a vote in a hundred across the edge of its cell.
    assert np.abs(found - expected).sum() <= 0.02 * 2 * expected.sum()


def test_tangents_are_those_of_eq_4_and_7() -> None:
    points, _, gradients = line_points(TRUTH, count=6)
    lam, cx, cy = -2e-6, 330.0, 228.0
    model = DivisionModel(lam, (cx, cy), (2000, 2000))
    g = model.undistorted_gradient(points, gradients)
    r = ((model.undistort(points) - (cx, cy)) * g).sum(axis=1)
    phi, offset = Tangents.of(points, gradients).under(lam, cx, cy)
    np.testing.assert_allclose(np.abs(np.cos(phi) * g[:, 0] + np.sin(phi) * g[:, 1]), 1, atol=1e-5)
    np.testing.assert_allclose(np.abs(offset), np.abs(r), atol=0.01)


def test_the_cube_keeps_points_in_their_cells() -> None:
    rng = np.random.default_rng(2)
    homogeneous = rng.normal(size=(500, 3))
    cells = face_cells(homogeneous, 48)
    np.testing.assert_array_equal(face_cells(face_points(cells, 48), 48), cells)
    np.testing.assert_array_equal(face_cells(-homogeneous, 48), cells)


@pytest.mark.parametrize("name", sorted(MEASURES))
def test_each_method_finishes_in_the_region(name: str) -> None:
    # Few samples: each measure is tried, not ranked.
    spec = CalibrationSpec(method=name, refine=False, samples=4, max_rounds=2)
    result = calibrate(
        render_board(board(size=(320, 240), center=(162.0, 118.0), square=21.0, lam=-1e-5)), spec
    )
    assert -1 / 110**2 < result.model.lam < 0
    assert abs(result.model.center[0] - 159.5) <= 16.001
    assert abs(result.model.center[1] - 119.5) <= 12.001
    assert result.source.method == name
    assert np.isfinite(result.quality.entropy)
