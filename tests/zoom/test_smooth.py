"""The diameter over time: still, in a zoom, and with false detections."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from endocal.zoom.clock import Elapsed
from endocal.zoom.smooth import DiameterFilter

SIGMA = 1e-3


def run(diameters: np.ndarray, sigma: float = SIGMA) -> np.ndarray:
    """The estimates for measured diameters, one a frame."""
    state = DiameterFilter()
    out = []
    for d in diameters:
        if not state.known:
            state.restart(float(d), sigma)
        else:
            state.predict()
            state.correct(float(d), sigma)
        out.append(state.diameter)
    return np.array(out)


def noisy(diameters: np.ndarray, seed: int = 0, sigma: float = SIGMA) -> np.ndarray:
    return diameters * np.exp(np.random.default_rng(seed).normal(0, sigma, len(diameters)))


def test_a_still_diameter_gets_stiller() -> None:
    estimates = run(noisy(np.full(300, 600.0)))[20:]
    assert np.std(np.log(estimates)) < 0.75 * SIGMA


@pytest.mark.parametrize("speed", [0.002, 0.01, 0.03, -0.01])
def test_a_steady_zoom_is_followed_without_lag(speed: float) -> None:
    n = 60
    truth = 400 * np.exp(speed * np.arange(n))
    estimates = run(noisy(truth))[10:]
    lag = np.mean(np.log(truth[10:] / estimates)) / speed
    # Half a frame of lag is half a frame's zoom; noise moves the mean of fifty by less than that.
    assert abs(lag) < 0.5


@pytest.mark.parametrize("speed", [0.005, 0.012, 0.03])
def test_a_zoom_that_sets_in_at_once_is_two_frames_late_at_most(speed: float) -> None:
    truth = 500 * np.exp(speed * np.maximum(np.arange(80) - 40, 0))
    estimates = run(noisy(truth, sigma=2e-4), sigma=2e-4)
    late = np.log(truth / estimates) / speed
    assert late.max() <= 2.1


def test_a_quick_zoom_that_speeds_up_and_slows_down_is_not_overshot() -> None:
    # To twice the size within a second, by a half cosine: the speed changes by 0.5 % per frame and frame.
    turn = np.clip((np.arange(70) - 20) / 25, 0, 1)
    truth = 500 * np.exp(np.log(2) * (1 - np.cos(np.pi * turn)) / 2)
    errors = np.abs(np.log(run(noisy(truth, sigma=2e-4), sigma=2e-4) / truth))
    # While the first measurement of the zoom waits for the next, the estimate is late by what came till then.
    assert errors.max() <= 0.01
    assert (errors > 0.003).sum() <= 2


@given(factor=st.floats(0.3, 3).filter(lambda f: abs(np.log(f)) > 0.02), at=st.integers(30, 55))
def test_one_false_detection_moves_nothing(factor: float, at: int) -> None:
    clean = noisy(np.full(60, 600.0))
    wrong = clean.copy()
    wrong[at] *= factor
    without = run(clean)
    assert np.abs(np.log(run(wrong) / without)).max() < 2 * SIGMA


@pytest.mark.parametrize("frames", [9, 12, 16])
def test_a_zoom_turned_by_hand_within_half_a_second_is_followed(frames: int) -> None:
    turn = np.clip((np.arange(40) - 10) / frames, 0, 1)
    truth = 400 * np.exp(np.log(2) * (1 - np.cos(np.pi * turn)) / 2)
    late = np.abs(np.log(run(noisy(truth)) / truth))
    # Out of step for three frames where it sets in and where it stops, at the speed that it has then.
    assert late.max() < 1.6 / frames
    assert np.median(late[10 : 10 + frames]) < 0.025
    assert late[10 + frames + 1 :].max() < 0.01


def test_false_circles_of_different_sizes_move_nothing() -> None:
    clean = noisy(np.full(60, 600.0))
    wrong = clean.copy()
    wrong[30:36] *= (1.10, 1.22, 1.16, 1.30, 1.21, 1.35)
    assert np.abs(np.log(run(wrong)[30:36] / run(clean)[29])).max() < 4 * SIGMA


@pytest.mark.parametrize(
    "bad", [(590, 620), (595, 610), (620, 590), (570, 604), (604, 640), (640, 604)]
)
def test_two_false_circles_that_disagree_move_nothing(bad: tuple[float, float]) -> None:
    estimates = run(np.concatenate([np.full(50, 600.0), bad, np.full(5, 600.0)]), sigma=3e-4)
    assert estimates == pytest.approx(np.full(57, 600.0), rel=3e-4)


def test_false_circles_on_both_sides_in_turn_move_nothing() -> None:
    bad = np.where(np.arange(8) % 2, 612.0, 588.0)
    estimates = run(np.concatenate([np.full(50, 600.0), bad]), sigma=3e-4)
    assert estimates == pytest.approx(np.full(58, 600.0), rel=3e-4)


@given(st.lists(st.floats(500, 700), min_size=2, max_size=2))
def test_after_false_circles_the_estimate_is_within_what_was_measured(bad: list[float]) -> None:
    measured = np.concatenate([np.full(50, 600.0), bad, np.full(6, 600.0)])
    estimates = run(measured, sigma=3e-4)
    # Less than a gate counts as noise, and moves the speed, too.
    assert estimates.min() >= measured.min() * (1 - 3e-3)
    assert estimates.max() <= measured.max() * (1 + 3e-3)
    assert estimates[-1] == pytest.approx(600, rel=3e-3)


@pytest.mark.parametrize("phase", [0.1, 0.2, 0.35, 0.5, 0.8])
@pytest.mark.parametrize("speed", [0.01, 0.03, 0.05])
def test_a_zoom_that_sets_in_between_two_frames_is_two_late_at_most(
    speed: float, phase: float
) -> None:
    truth = 500 * np.exp(speed * np.maximum(np.arange(80) - 40 - phase, 0))
    late = np.log(truth / run(noisy(truth, sigma=2e-4), sigma=2e-4)) / speed
    assert np.abs(late).max() <= 2.1
    assert np.abs(late[45:]).max() <= 0.1


def test_a_real_jump_is_believed_after_three_frames() -> None:
    truth = np.where(np.arange(60) < 30, 600.0, 900.0)
    estimates = run(noisy(truth))
    assert estimates[29] == pytest.approx(600, rel=0.01)
    assert estimates[32:] == pytest.approx(np.full(28, 900), rel=0.01)


def test_the_stated_uncertainty_is_that_of_the_estimates() -> None:
    state = DiameterFilter()
    rng = np.random.default_rng(3)
    errors = []
    state.restart(600.0, SIGMA)
    for _ in range(500):
        state.predict()
        state.correct(600 * float(np.exp(rng.normal(0, SIGMA))), SIGMA)
        errors.append(np.log(state.diameter / 600) / state.sigma)
    assert 0.5 < np.std(errors) < 1.5


def test_false_circles_far_apart_in_time_never_agree() -> None:
    state = DiameterFilter()
    state.restart(600.0, 3e-4)
    for _ in range(4):
        # Two seconds of tracking, then the same false circle.
        for _ in range(50):
            state.scale(0.0, 1e-5)
        assert not state.correct(530.0, 3e-4)
    assert state.diameter == pytest.approx(600)


def test_a_jump_in_a_video_of_a_frame_a_second_is_believed() -> None:
    state = DiameterFilter()
    state.restart(600.0, 3e-4)
    taken = []
    for _ in range(3):
        state.predict(Elapsed(1.0, 1.0))
        taken.append(state.correct(700.0, 3e-4))
    assert taken == [False, False, True]


@pytest.mark.parametrize("dropped", [1, 3, 6])
@pytest.mark.parametrize("speed", [0.004, 0.016, -0.016])
def test_frames_dropped_amid_a_zoom_leave_no_trace(speed: float, dropped: int) -> None:
    state = DiameterFilter()
    state.restart(400.0, 3e-4, 0.015)
    at = 0
    for i in range(60):
        frames = 1 + dropped * (i in (30, 31, 45))
        at += frames
        state.predict(Elapsed(float(frames), frames * 0.04))
        assert state.correct(400 * float(np.exp(speed * at)), 3e-4) or i < 3
        if i > 3:
            assert abs(np.log(state.diameter / 400) - speed * at) < 3 * state.sigma


@given(st.lists(st.floats(590, 610), min_size=1, max_size=20))
def test_frames_of_half_the_length_tell_the_same_speed(measured: list[float]) -> None:
    one, two = DiameterFilter(), DiameterFilter()
    for state in (one, two):
        state.restart(600.0, 1e-3, 0.01)
    for index, diameter in enumerate(measured):
        # The second begins to count in half frames later on.
        if index == 5:
            two.recount(0.5)
        one.predict()
        two.predict(Elapsed(1.0 if index < 5 else 2.0, 0.04))
        if index <= 5:
            assert two.diameter == pytest.approx(one.diameter, rel=1e-12)
            one.correct(diameter, 1e-3)
            two.correct(diameter, 1e-3)


@pytest.mark.parametrize("speed", [(0.0, 0.01), (0.01, 0.0), (0.0, 0.05), (0.03, -0.02)])
def test_while_a_measurement_waits_the_estimate_is_as_doubtful_as_it_is_off(
    speed: tuple[float, float],
) -> None:
    state = DiameterFilter()
    state.restart(500.0, 3e-4)
    truth = np.cumsum(np.where(np.arange(60) < 30, *speed))
    for logarithm in truth:
        state.predict()
        state.correct(500 * float(np.exp(logarithm)), 3e-4)
        assert abs(np.log(state.diameter / 500) - logarithm) <= 3 * np.hypot(
            state.sigma, state.pending
        )
    assert state.pending == 0


def test_a_wild_circle_adds_no_more_doubt_than_a_zoom_can_explain() -> None:
    state = DiameterFilter()
    state.restart(600.0, 3e-4)
    state.predict()
    assert not state.correct(1200.0, 3e-4)
    assert state.pending == pytest.approx(0.06)
    state.predict()
    assert state.correct(600.0, 3e-4)
    assert state.pending == 0


def test_a_zoom_is_not_taken_to_go_on_through_a_long_gap() -> None:
    state = DiameterFilter()
    state.restart(300.0, 3e-4, 0.01)
    for i in range(20):
        state.predict()
        state.correct(300 * float(np.exp(0.01 * i)), 3e-4)
    before = state.diameter
    state.predict(Elapsed(50.0, 2.0))
    assert state.diameter == pytest.approx(before)
    assert state.sigma >= 0.09


@given(speed=st.floats(0.02, 0.06), seed=st.integers(0, 1000))
def test_a_zoom_to_the_end_stop_and_back_is_two_frames_late_at_most(
    speed: float, seed: int
) -> None:
    there = np.concatenate([np.zeros(20), np.arange(13), np.full(4, 12)])
    true = 500 * np.exp(speed * np.concatenate([there, there[::-1], np.zeros(10)]))
    errors = np.abs(np.log(run(noisy(true, seed, 3e-4)) / true))
    assert errors.max() <= 2 * speed + 0.01
    assert errors[-20:].max() < 0.003


@pytest.mark.parametrize("frames", [2, 3, 7])
def test_frames_gone_by_at_once_leave_as_much_doubt_as_one_by_one(frames: int) -> None:
    at_once, in_turn = DiameterFilter(), DiameterFilter()
    for state in (at_once, in_turn):
        state.restart(500.0, SIGMA, 2e-3)
    at_once.predict(Elapsed(frames, frames / 25))
    for _ in range(frames):
        in_turn.predict(Elapsed(1.0, 1 / 25))
    assert at_once.sigma == pytest.approx(in_turn.sigma, rel=1e-9)


def test_a_pull_takes_from_the_variance_and_owes_what_it_lacks() -> None:
    state = DiameterFilter()
    state.restart(400.0, 0.02)
    state.pull(0.01, 0.01**2)
    assert state.diameter == pytest.approx(400 * math.exp(0.01))
    assert state.sigma == pytest.approx(math.sqrt(0.02**2 - 0.01**2))
    assert state.owed == 0.0
    state.pull(0.0, 0.03**2)
    assert (state.sigma, state.owed) == (0.0, pytest.approx(6e-4))
    # Nothing is given back that was not there.
    state.pull(0.0, -(0.03**2))
    assert state.sigma == pytest.approx(math.sqrt(0.02**2 - 0.01**2))
    assert state.owed == 0.0


def test_a_measurement_ends_what_is_owed() -> None:
    state = DiameterFilter()
    state.restart(400.0, 0.02)
    state.pull(0.0, 0.03**2)
    assert state.owed > 0
    assert state.correct(400.1, 1e-3)
    assert state.owed == 0.0


def test_the_longer_one_waits_the_farther_a_zoom_may_have_come() -> None:
    state, pending = DiameterFilter(), []
    state.restart(500.0, 3e-4)
    for i in range(12):
        state.predict()
        # Two that contradict each other by turns.
        assert not state.correct(500 * (1.5 if i % 2 else 1.4), 3e-4)
        pending.append(state.pending)
    assert pending[:3] == pytest.approx([0.06, 0.12, 0.18])
    assert pending[-1] == pytest.approx(math.log(1.5))
