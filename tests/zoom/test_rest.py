"""A hand's slow to and fro is no zoom; a zoom counts in full, from before it was noticed on."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from endocal.zoom.parallax import ScaleStep
from endocal.zoom.rest import RestSpec, ZoomRest, ZoomShare

FRAME = 0.04
# How well the picture tells zoom and approach together, and the one from the other, per s.
TOGETHER = 0.002


def shares(
    zoom: np.ndarray,
    approach: float | np.ndarray = 0.0,
    apart: float = 0.01,
    seconds: float = FRAME,
    aside: float = 0.0,
    told: float | None = None,
    lasting: float = 1.0,
    curved: float = 0.0,
) -> list[ZoomShare]:
    """What becomes of the steps of a picture that tells the two apart by ``apart`` per s.

    The camera goes aside by ``aside`` distances per s, both ways. The zoom moves at ``told`` per s before.
    The part ``lasting`` of errors is that of the next step too; the scene is ``curved`` so much.
    """
    sum_, difference = np.array([1.0, 1.0]) / 2, np.array([1.0, -1.0]) / 2
    information = np.outer(sum_, sum_) / TOGETHER**2 + np.outer(difference, difference) / apart**2
    information /= seconds**2
    rest, out = ZoomRest(), []
    rest.forget(told)
    for z, a in np.broadcast(zoom, approach):
        target = information @ np.array([z, a])
        went = np.full(2, aside * seconds)
        step = ScaleStep(float(z), 1e-4, float(a), information, target, went, lasting, curved)
        out.append(rest.take(step, seconds))
    return out


def total(*args: object, **options: float) -> np.ndarray:
    """What has been let through after each step."""
    return np.cumsum([s.logarithm for s in shares(*args, **options)])  # type: ignore[arg-type]


@pytest.mark.parametrize("apart", [0.01, 0.3])
def test_a_swaying_hand_is_no_zoom(apart: float) -> None:
    # 2 % of the distance to and fro in 5 s: 2.5 % per s at most.
    t = np.arange(500) * FRAME
    steps = np.diff(0.02 * np.sin(2 * np.pi * t / 5))
    assert not total(steps, apart=apart).any()


def test_a_camera_that_comes_nearer_is_no_zoom_where_the_picture_tells() -> None:
    assert not total(np.zeros(50), approach=0.2 * FRAME).any()


@given(speed=st.floats(0.12, 1.0), sign=st.sampled_from([-1, 1]))
def test_a_zoom_counts_in_full(speed: float, sign: int) -> None:
    steps = np.concatenate([np.zeros(20), np.full(40, sign * speed * FRAME), np.zeros(20)])
    # Where it ends, a few frames at rest are weighed with those of the zoom.
    assert total(steps)[-1] == pytest.approx(steps.sum(), rel=0.05, abs=0.005)


def pieces(*parts: tuple[float, int]) -> np.ndarray:
    """The steps of a zoom at so many per s for so many frames, one piece after another, and then at rest."""
    return np.concatenate([np.full(frames, speed * FRAME) for speed, frames in (*parts, (0, 25))])


@pytest.mark.parametrize("speed", [0.2, -0.5, 1.0])
def test_a_zoom_that_turns_counts_once(speed: float) -> None:
    # While it turns the mean over the window passes through none: at rest, for a moment.
    steps = pieces((0, 20), (speed, 20), (-speed, 20))
    assert total(steps)[-1] == pytest.approx(0, abs=0.002)


@pytest.mark.parametrize("pause", [4, 8, 10])
def test_a_zoom_that_pauses_counts_once(pause: int) -> None:
    steps = pieces((0, 20), (0.5, 15), (0, pause), (0.5, 15))
    # Half a percent of it may pass for the hand's.
    assert total(steps)[-1] == pytest.approx(steps.sum(), rel=0.007)


@settings(max_examples=40, deadline=None)
@given(
    parts=st.lists(st.tuples(st.floats(0, 1), st.integers(1, 25), st.integers(0, 12)), max_size=4),
    sign=st.sampled_from([-1, 1]),
)
def test_never_more_counts_than_there_was(parts: list[tuple[float, int, int]], sign: int) -> None:
    steps = pieces(*(p for speed, frames, pause in parts for p in ((speed, frames), (0, pause))))
    found = shares(sign * steps)
    counted = sign * np.cumsum([s.logarithm for s in found])
    seeming = sign * np.cumsum([s.seeming for s in found])
    assert (counted <= np.cumsum(steps) + 1e-9).all()
    # Nor is more taken back than seemed one.
    assert (seeming >= -1e-9).all()


@settings(max_examples=40, deadline=None)
@given(
    parts=st.lists(
        st.tuples(
            st.just(0.0) | st.floats(0.12, 1) | st.floats(-1, -0.12),
            # No shorter than the window: less of it may pass unseen.
            st.integers(9, 25),
        ),
        max_size=6,
    )
)
def test_a_zoom_to_and_fro_with_pauses_counts_in_full(parts: list[tuple[float, int]]) -> None:
    steps = pieces((0, 13), *parts)
    # What stays undecided is the window, at the speed of a zoom that is just not seen.
    assert total(steps)[-1] == pytest.approx(steps.sum(), abs=0.32 * 0.12)


def test_a_gentle_start_is_made_up_for() -> None:
    # 1x to 2x in 4 s, easing in and out.
    s = np.linspace(0, 1, 101)
    steps = np.diff(np.log(2) * s * s * (3 - 2 * s))
    found = total(steps)
    # What the history holds before the zoom is noticed is late by then; all but that comes in.
    assert np.abs(found - np.cumsum(steps)).max() < 0.03
    assert found[-1] == pytest.approx(np.log(2), abs=0.02)


def test_seconds_count_and_not_frames() -> None:
    slow, quick = np.full(100, 0.0015), np.full(100, 0.0015)
    assert not total(slow, apart=0.05, seconds=0.04).any()
    assert total(quick, apart=0.05, seconds=0.008)[-1] == pytest.approx(0.15, rel=0.1)


def test_what_seemed_a_zoom_at_rest_is_taken_off_the_zoom_that_follows() -> None:
    # 2.5 % per s for 3 s, which is none, goes on while a real zoom sets in.
    false, real = np.full(100, 0.025 * FRAME), np.where(np.arange(100) < 75, 0, 0.4 * FRAME)
    found = total(false + real)
    assert found[74] == 0
    # Within half a second it is forgotten by a good half; without any memory all 0.025 would stay.
    assert found[-1] == pytest.approx(real.sum(), abs=0.02)


def test_what_the_picture_does_not_tell_is_in_doubt() -> None:
    steps = np.full(30, 0.15 * FRAME)
    told = shares(steps, apart=0.01)[-1]
    untold = shares(steps, apart=1.0)[-1]
    assert told.logarithm > 0
    assert told.doubt < 0.03 < 0.04 < untold.doubt
    # Nearly nothing happens: then a zoom that goes unnoticed is a slow one.
    assert shares(steps / 100, apart=1.0)[-1].doubt < untold.doubt / 2


def test_a_zoom_that_is_going_on_needs_no_proof_anew() -> None:
    rest = ZoomRest(RestSpec(starts=0.01))
    information = np.diag([0.04**-2.0, 0.04**-2.0]) / FRAME**2
    target = information @ [0.1 * FRAME, 0.0]
    step = ScaleStep(0.1 * FRAME, 1e-4, 0.0, information, target, np.zeros(2))
    rest.forget()
    assert rest.take(step, FRAME).logarithm == 0
    assert rest.rests
    rest.forget(speed=0.1)
    assert rest.take(step, FRAME).logarithm == pytest.approx(0.1 * FRAME, rel=0.01)
    assert not rest.rests


@pytest.mark.parametrize("speed", [0.08, -0.08])
def test_a_zoom_goes_on_as_the_rim_told_where_the_picture_does_not_tell(speed: float) -> None:
    # A hand might as well come nearer at that speed.
    steps = np.full(12, speed * FRAME)
    assert total(steps, apart=1.0, told=speed)[-1] == pytest.approx(steps.sum(), rel=0.4)
    assert not total(steps, apart=1.0, told=0.0).any()


@pytest.mark.parametrize("apart", [0.01, 1.0])
def test_a_zoom_that_the_rim_told_may_stop(apart: float) -> None:
    # The hand stands still, too: nothing but a hand that retreats at the same speed would hide a zoom.
    found = total(np.zeros(50), apart=apart, told=0.3)
    assert abs(found[-1]) < 0.02
    assert not np.diff(found[25:]).any()


def test_what_the_rim_told_fades() -> None:
    # A zoom at the told speed, then at another: after a while the picture alone counts.
    steps = np.concatenate([np.full(50, 0.15 * FRAME), np.full(50, 0.4 * FRAME)])
    assert total(steps, apart=0.05, told=0.15)[-1] == pytest.approx(steps.sum(), rel=0.05)


def test_a_camera_that_roams_comes_nearer_too() -> None:
    # 26 % per s, of which the picture hardly says what it is: a quiet hand does not do that.
    steps = np.where(np.arange(75) < 50, 0, 0.26 * FRAME)
    assert total(steps, apart=0.2)[-1] == pytest.approx(steps.sum(), rel=0.15)
    assert not total(steps, apart=0.2, aside=0.3).any()


def test_a_hand_that_stands_still_is_not_expected_to_come_nearer() -> None:
    # What the picture hardly tells apart is then the zoom's almost whole; a hand that sways shares in it.
    steps = np.where(np.arange(75) < 50, 0, 0.3 * FRAME)
    still, swaying = (total(steps, apart=0.2, aside=speed, told=0.0)[-1] for speed in (0.0, 0.1))
    assert still == pytest.approx(steps.sum(), rel=0.03)
    assert swaying < still


def test_what_a_hand_is_expected_to_do_is_what_it_did_of_late() -> None:
    information, rest = np.eye(2) / 0.01**2, ZoomRest()
    assert rest.hand == pytest.approx(0.07, rel=0.1)
    for speed, least, most in ((0.0, 0.01, 0.035), (0.3, 0.2, 0.3)):
        step = ScaleStep(0.0, 1e-4, 0.0, information, np.zeros(2), np.full(2, speed * FRAME))
        for _ in range(75):
            rest.take(step, FRAME)
        assert least < rest.hand < most


def test_what_seemed_a_zoom_at_rest_is_told_and_taken_back_when_it_counts() -> None:
    slow, quick = np.full(25, 0.02 * FRAME), np.full(25, 0.4 * FRAME)
    found = shares(np.concatenate([slow, quick]))
    seeming = np.array([s.seeming for s in found])
    assert seeming[:25].sum() == pytest.approx(slow.sum(), rel=0.2)
    assert (seeming[:25] >= 0).all()
    assert seeming.min() < 0
    # All that counts as zoom and all that still seems one make up the dilation.
    counted = sum(s.logarithm for s in found) + seeming.sum()
    assert counted == pytest.approx(slow.sum() + quick.sum(), rel=0.1)
    assert all(s.seeming_doubt == 0 for s in found if s.logarithm)


def test_a_camera_that_comes_nearer_quickly_makes_what_seems_a_slow_zoom_doubtful() -> None:
    quiet = shares(np.zeros(25), approach=0.0)[-1]
    nearer = shares(np.zeros(25), approach=0.15 * FRAME)[-1]
    assert nearer.logarithm == 0
    assert nearer.seeming_doubt > 0.1 > 0.03 > quiet.seeming_doubt


def eased(most: float) -> np.ndarray:
    """The steps of a zoom that goes out by the logarithm ``most`` in 10 s and back, by a cosine."""
    t = np.linspace(0, 1, 501)
    return np.diff(most * (1 - np.cos(2 * np.pi * t)) / 2)


def test_a_slow_zoom_is_noticed_where_the_errors_of_steps_do_not_last() -> None:
    steps = np.full(75, 0.04 * FRAME)
    assert not total(steps, apart=0.02).any()
    found = total(steps, apart=0.02, lasting=0.0)
    assert found[12] > 0
    assert found[-1] == pytest.approx(steps.sum(), rel=0.1)


@pytest.mark.parametrize("apart", [0.005, 0.02])
def test_a_zoom_that_eases_to_its_turn_is_followed_where_errors_do_not_last(apart: float) -> None:
    steps = eased(np.log(2.5))
    followed = total(steps, apart=apart, lasting=0.0, told=None)
    off = np.abs(followed - np.cumsum(steps))
    # 2 % of the diameter where it hardly moves, as it begins and turns; little of that is left.
    assert off.max() < 0.02
    assert off[-25:].max() < 0.012
    # Where they last it is missed for longer, and what is missed stays away.
    assert np.abs(total(steps, apart=apart) - np.cumsum(steps)).max() > 2 * off.max()


def test_a_gentle_start_counts_from_where_it_seemed_one() -> None:
    # Speeding up to 12 % per s within 4 s, before a hand that goes aside at 2 % per s.
    steps = np.linspace(0, 0.12, 100) * FRAME
    found = total(steps, apart=0.05, lasting=0.1, aside=0.02)
    first = np.flatnonzero(found)[0]
    # More than the history holds comes in at once.
    history = steps[first - 12 : first + 1].sum()
    assert found[first] > 1.5 * history
    assert found[first] <= steps[: first + 1].sum()


def test_how_sure_many_steps_are_is_not_how_far_they_are_off() -> None:
    # Noise of each step's own tells that there is a zoom; all of them may yet be off as one is.
    steps = np.full(30, 0.15 * FRAME)
    own, common = (shares(steps, apart=0.05, lasting=part)[-1] for part in (0.0, 1.0))
    assert own.doubt > 0.8 * common.doubt


def test_before_a_curved_scene_a_hand_that_sways_may_seem_a_zoom() -> None:
    steps = np.where(np.arange(250) < 200, 0, 0.08 * FRAME)
    # A flat one, or a hand that stands still, hides none.
    for aside, curved in ((0.04, 0.0), (0.0, 0.3)):
        found = total(steps, apart=0.01, lasting=0.0, aside=aside, curved=curved)
        assert found[-1] == pytest.approx(steps.sum(), rel=0.1)
    assert not total(steps, apart=0.01, lasting=0.0, aside=0.04, curved=0.7).any()
