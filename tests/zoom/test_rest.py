"""A hand's slow to and fro is no zoom; a zoom counts in full, from before it was noticed on."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from endocal.zoom.parallax import ScaleStep
from endocal.zoom.rest import ZoomRest

FRAME = 0.04


def total(steps: np.ndarray, approach: float = 0.0, seconds: float = FRAME) -> np.ndarray:
    """What has been let through after each step."""
    rest = ZoomRest()
    taken = [rest.take(ScaleStep(float(s), 1e-4, approach), seconds) for s in steps]
    return np.cumsum(taken)


def test_a_swaying_hand_is_no_zoom() -> None:
    # 2 % of the distance to and fro in 5 s: 2.5 % per s at most.
    t = np.arange(500) * FRAME
    steps = np.diff(0.02 * np.sin(2 * np.pi * t / 5))
    assert not total(steps).any()


@given(speed=st.floats(0.06, 1.0), sign=st.sampled_from([-1, 1]))
def test_a_zoom_counts_in_full(speed: float, sign: int) -> None:
    steps = np.concatenate([np.zeros(20), np.full(40, sign * speed * FRAME), np.zeros(20)])
    assert total(steps)[-1] == pytest.approx(steps.sum(), rel=1e-9)


def test_a_gentle_start_is_made_up_for() -> None:
    # 1x to 2x in 4 s, easing in and out.
    s = np.linspace(0, 1, 101)
    steps = np.diff(np.log(2) * s * s * (3 - 2 * s))
    found = total(steps)
    # What the window holds before the zoom is noticed is late by then, and little; all but that comes in.
    assert np.abs(found - np.cumsum(steps)).max() < 0.012
    assert found[-1] == pytest.approx(np.log(2), abs=0.01)


def test_what_a_camera_does_at_the_same_time_raises_the_bar() -> None:
    steps = np.full(50, 0.002)
    assert total(steps)[-1] == pytest.approx(0.1)
    assert not total(steps, approach=0.004).any()


def test_seconds_count_and_not_frames() -> None:
    per_frame = np.full(100, 0.001)
    assert not total(per_frame, seconds=0.04).any()
    assert total(per_frame, seconds=0.02)[-1] == pytest.approx(0.1)


def test_what_seemed_a_zoom_at_rest_is_taken_off_the_zoom_that_follows() -> None:
    # 2.5 % per s for 3 s, which is none, goes on for a second while a real zoom sets in.
    false, real = np.full(100, 0.025 * FRAME), np.where(np.arange(100) < 75, 0, 0.4 * FRAME)
    found = total(false + real)
    # It is forgotten while it goes on: over a second by half, at most.
    assert found[74] == 0
    assert found[-1] == pytest.approx(real.sum(), abs=0.5 * 0.025)
