"""The methods that rest on chosen lines: Wang's circle arcs, and HTRDC's single line."""

from typing import Any

import numpy as np
import pytest

from endocal import CalibrationSpec, calibrate
from endocal.calibration.fit.plumb_line import Prior
from endocal.calibration.hough.hewg import Voters, hewg
from endocal.calibration.methods import htrdc, wang
from endocal.calibration.search import Region, search
from endocal.errors import CalibrationError, UsageError
from endocal.synth.board import BoardScene, render_board, true_lines

from ..scenes import TRUTH, board, line_points

FREE = Prior((319.5, 239.5), (32.0, 24.0))
# Two points of a line that is to be spoilt.
START = (1, 2), (3, 4)


def chosen(scene: BoardScene, each: int = 12) -> tuple[tuple[tuple[float, float], ...], ...]:
    """A few points on each true line, as a person would click them, but rightly."""
    lines = []
    for line in true_lines(scene):
        some = line[np.linspace(0, len(line) - 1, each).astype(int)]
        lines.append(tuple((float(x), float(y)) for x, y in some))
    return tuple(lines)


def test_an_arc_is_the_circle_that_a_line_becomes() -> None:
    points, labels, _ = line_points(TRUTH, count=6)
    lam, cx, cy = TRUTH
    for i in range(6):
        line = points[labels == i]
        b, c, d, a = wang.fit_arc(line).coefficients
        assert b * b + c * c - 4 * a * d == pytest.approx(1, abs=1e-6)
        x, y = line.T
        np.testing.assert_allclose(a * (x * x + y * y) + b * x + c * y + d, 0, atol=1e-6)
        # The relation of Wang et al. that holds for every line.
        t = cx * cx + cy * cy - 1 / lam
        assert a * t + b * cx + c * cy + d == pytest.approx(0, abs=1e-5)


def test_exact_arcs_give_the_lens() -> None:
    points, labels, _ = line_points(TRUTH, count=6)
    arcs = [wang.fit_arc(points[labels == i]) for i in range(6)]
    lam, cx, cy = wang.model_of(arcs, FREE)
    assert lam == pytest.approx(TRUTH[0], rel=1e-6)
    assert (cx, cy) == pytest.approx(tuple(TRUTH[1:]), abs=1e-3)
    given = wang.model_of(arcs, Prior(tuple(TRUTH[1:]), (0.0, 0.0)))
    np.testing.assert_allclose(given, TRUTH, rtol=1e-6)


def test_a_line_chosen_wrongly_weighs_little() -> None:
    points, labels, _ = line_points(TRUTH, count=10)
    rng = np.random.default_rng(0)
    noisy = points + rng.normal(0, 0.1, points.shape)
    lines = [noisy[labels == i] for i in range(10)]
    bent = lines[0] + np.outer(4 * np.sin(np.linspace(0, np.pi, len(lines[0]))), [0.6, 0.8])
    lam, cx, cy = wang.model_of([wang.fit_arc(line) for line in [*lines, bent]], FREE)
    # The others alone tell lambda to 0.05 %, and the centre to 0.05 px.
    assert lam == pytest.approx(TRUTH[0], rel=0.001)
    assert np.hypot(cx - TRUTH[1], cy - TRUTH[2]) < 0.2


def test_lines_that_tell_nothing_are_refused() -> None:
    # Lines through one point, all of one direction.
    points = np.stack([np.linspace(0, 600, 20), np.full(20, 200.0)], axis=1)
    arcs = [wang.fit_arc(points)] * 3
    with pytest.raises(CalibrationError, match="do not tell the lens"):
        wang.model_of(arcs, FREE)


def test_lines_from_a_person_are_used_as_they_are() -> None:
    scene = board()
    lines = chosen(scene)
    picture = render_board(scene)
    spec = CalibrationSpec(method="wang", refine=False, lines=lines)
    found = calibrate(picture, spec).model
    # Exact points, far better than any edge: the answer is theirs, not the picture's.
    assert found.lam == pytest.approx(scene.model.lam, rel=1e-4)
    assert found.center == pytest.approx(scene.model.center, abs=0.05)


def test_htrdc_finds_lambda_from_one_line_and_the_right_centre() -> None:
    scene = board()
    spec = CalibrationSpec(
        method="htrdc", refine=False, center=scene.model.center, lines=chosen(scene, 150)
    )
    found = calibrate(render_board(scene), spec).model
    # One line in cells of a pixel and half a degree.
    assert found.lam == pytest.approx(scene.model.lam, rel=0.1)


def test_htrdcs_peak_is_highest_where_the_line_is_straight() -> None:
    points, labels, gradients = line_points(TRUTH, count=1, each=300)
    cost = htrdc.prepare(points, (640, 480))
    lams = TRUTH[0] * np.linspace(0, 2, 41)
    costs = cost(lams, TRUTH[1:2], TRUTH[2:])[:, 0, 0]
    assert lams[costs.argmin()] == pytest.approx(TRUTH[0], rel=0.2)
    assert len(labels) == len(gradients) == 300


def test_lines_need_a_method_that_takes_them() -> None:
    lines = (((0.0, 0.0), (1.0, 1.0), (2.0, 2.5)),)
    with pytest.raises(UsageError, match="--lines goes with --method wang or htrdc"):
        CalibrationSpec(lines=lines)
    with pytest.raises(UsageError, match="3 points or more"):
        CalibrationSpec(method="wang", lines=(((0.0, 0.0), (1.0, 1.0)),))
    with pytest.raises(CalibrationError, match="only 1 lines: the method wang needs 3"):
        calibrate(render_board(board()), CalibrationSpec(method="wang", lines=lines, refine=False))
    off = (((0.0, 0.0), (700.0, 1.0), (2.0, 2.5)),)
    with pytest.raises(UsageError, match="line 1 leaves the 640x480 px picture at 700,1"):
        calibrate(render_board(board()), CalibrationSpec(method="wang", lines=off, refine=False))


def test_the_search_keeps_a_centre_that_is_one_value() -> None:
    points, _, gradients = line_points(TRUTH)
    voters = Voters.of(points, gradients, 480)
    region = Region((-6e-6, -1e-7), (TRUTH[1], TRUTH[1]), (TRUTH[2], TRUTH[2]))
    found = search(lambda *axes: hewg(voters, *axes), region, 10, 1e-9, 20)
    np.testing.assert_array_equal(found.params[1:], TRUTH[1:])
    assert found.params[0] == pytest.approx(TRUTH[0], rel=0.03)


@pytest.mark.parametrize(
    "lines",
    [
        5,
        "lines",
        (START,),
        ((*START, ("a", 6)),),
        ((*START, (np.nan, 6.0)),),
        ((*START, (5, 6, 7)),),
        ((*START, [5, 6]),),
        ((*START, 5),),
    ],
)
def test_what_are_no_lines(lines: Any) -> None:
    with pytest.raises(UsageError, match=r"--lines: .*needed"):
        CalibrationSpec(method="wang", lines=lines)
