"""A slow zoom adds up; the mistakes of a hand that comes back do not."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from endocal.zoom.slow import SlowSpec, SlowZoom

FRAME = 0.04


def followed(seeming: np.ndarray, deviation: float) -> list[tuple[float, float]]:
    """The slow zoom and its doubt after each frame that seemed a zoom, known to ``deviation`` per s."""
    slow, out = SlowZoom(), []
    for logarithm in seeming:
        slow.take(float(logarithm), deviation, FRAME)
        out.append((slow.logarithm, slow.sigma))
    return out


@given(speed=st.floats(0.04, 0.06), sign=st.sampled_from([-1, 1]), deviation=st.floats(0.01, 0.05))
def test_a_zoom_that_goes_on_is_believed_in_the_end(
    speed: float, sign: int, deviation: float
) -> None:
    total = sign * speed * 8
    zoom, doubt = followed(np.full(200, sign * speed * FRAME), deviation)[-1]
    assert abs(zoom - total) < min(0.3 * abs(total), 2 * doubt)


def test_meanwhile_it_is_within_the_doubt() -> None:
    steps = np.full(200, 0.043 * FRAME)
    for true, (zoom, doubt) in zip(np.cumsum(steps), followed(steps, 0.045), strict=True):
        assert abs(zoom - true) < 2.5 * doubt + 0.002


def test_the_sway_of_a_hand_is_no_zoom() -> None:
    # Of 10 % of the distance to and fro a third seems a zoom.
    t = np.arange(500) * FRAME
    steps = np.diff(0.033 * np.sin(2 * np.pi * t / 5))
    found = np.array(followed(steps, 0.04))
    assert not found[:, 0].any()
    assert found[:, 1].max() < 0.05


def test_before_a_quiet_scene_there_is_little_doubt() -> None:
    zoom, doubt = followed(np.zeros(200), 0.01)[-1]
    assert zoom == 0
    assert doubt < 0.01


def test_the_doubt_is_that_of_mistakes_as_expected() -> None:
    # Mistakes that last for the memory and are taken back; there is no zoom at all.
    spec, rng = SlowSpec(), np.random.default_rng(3)
    deviation, kept, off = 0.05, math.exp(-FRAME / spec.memory), []
    for _ in range(200):
        speed, moved, steps = rng.normal(0, deviation), 0.0, []
        for _ in range(200):
            speed = kept * speed + math.sqrt(1 - kept**2) * rng.normal(0, deviation)
            before, moved = moved, moved * (1 - FRAME / spec.back) + speed * FRAME
            steps.append(moved - before)
        off += [zoom / doubt for zoom, doubt in followed(np.array(steps), deviation)[50::10]]
    assert np.percentile(np.abs(off), 95) < 2


def test_a_restart_forgets_all() -> None:
    slow = SlowZoom()
    for _ in range(200):
        slow.take(0.002, 0.02, FRAME)
    assert slow.logarithm == pytest.approx(0.4, rel=0.1)
    slow.restart()
    assert slow.logarithm == slow.sigma == 0
