"""Boards through fisheyes: the floor they are held to, and how near calibration comes to it."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from endocal.benchmarks import fisheye_boards
from endocal.benchmarks.corner_floor import LEAST_DENOMINATOR, least_straightness
from endocal.benchmarks.corner_score import straightness
from endocal.benchmarks.fisheye_boards import Outcome, run_board, summarise
from endocal.model import DivisionModel
from endocal.synth.board import BoardScene, true_corners
from endocal.synth.fisheye import Fisheye
from endocal.synth.pattern import Pattern, Pose

SIZE, CENTER = (748, 480), (384.0, 236.0)
OUTCOME = Outcome(3, "equidistant", 70.0, "division", "doubtful", s=0.15, floor=0.1, far_out=3.0)


def seen(lens: DivisionModel | Fisheye, square: float = 42.0) -> np.ndarray:
    pose = Pose((340.0, 250.0), square, tilt=30, tilt_axis=20, rotation=8, focal=200.0)
    return true_corners(BoardScene(lens, Pattern(cols=9, rows=7), pose))[0]


@pytest.mark.parametrize("lam2", [0.0, -2e-11], ids=["division", "division2"])
def test_the_floor_under_a_lens_of_the_model_is_nothing(lam2: float) -> None:
    lens = DivisionModel(-7e-6, CENTER, SIZE, lam2=lam2)
    least, best = least_straightness(seen(lens), SIZE, "division2" if lam2 else "division")
    assert least < 0.002
    assert best.lam + best.lam2 * 150**2 == pytest.approx(-7e-6 + lam2 * 150**2, rel=0.01)


def test_the_floor_is_no_higher_than_models_near_it() -> None:
    corners = seen(Fisheye("equisolid", 200.0, CENTER, SIZE))
    least, best = least_straightness(corners, SIZE)
    second, _ = least_straightness(corners, SIZE, "division2")
    assert second < 0.5 * least
    assert least == straightness(corners, best)
    rng = np.random.default_rng(2)
    for _ in range(50):
        x, y = best.center + rng.normal(0, 1, 2)
        near = replace(best, lam=best.lam * rng.normal(1, 0.01), center=(x, y))
        assert straightness(corners, near) > least


def test_the_floor_does_not_pass_the_pole() -> None:
    corners = seen(Fisheye("orthographic", 300.0, CENTER, SIZE), square=90.0)
    _, best = least_straightness(corners, SIZE)
    q = ((corners - best.center) ** 2).sum(axis=-1)
    assert best.denominator(q).min() >= LEAST_DENOMINATOR


@pytest.mark.parametrize("seed", [2, 3])
def test_calibration_comes_near_the_floor(seed: int) -> None:
    one, two = run_board(seed)
    assert (one.model, two.model) == ("division", "division2")
    assert one.floor >= two.floor
    for outcome in (one, two):
        assert outcome.near
        assert not outcome.degenerate
        # The corners that score are wrong by 0.05 px, which leaves a floor no model can be told to reach.
        assert outcome.s < 1.25 * outcome.floor
    json.dumps([one.data(), two.data()], allow_nan=False)


def test_calibration_comes_near_the_floor_at_the_pole() -> None:
    """One board at the rim sends its farthest corner as far out as the floor lets it."""
    for outcome in run_board(8):
        assert outcome.degenerate
        assert outcome.s < 1.2 * outcome.floor


def test_what_is_near_and_what_is_summed_up() -> None:
    far = replace(OUTCOME, seed=4, s=0.5)
    lost = replace(OUTCOME, seed=5, s=math.inf, far_out=50.0)
    assert OUTCOME.near
    assert not far.near
    assert not lost.near
    assert replace(far, s=0.29).near, "0.2 px above the floor is near, too"
    assert lost.degenerate
    assert not far.degenerate
    summary = summarise([OUTCOME, far, lost])
    assert (summary.boards, summary.far, summary.worst) == (3, (4, 5), math.inf)
    assert summary.median == pytest.approx(5.0)
    assert lost.data()["s"] is None
    assert lost.data()["ratio"] is None


def test_progress_gets_each_board() -> None:
    told: list[int] = []
    fisheye_boards.run([2], progress=lambda o: told.append(o.seed))
    assert told == [2]
