"""The doubt that adds up from a speed that is off by an unknown, slowly changing amount."""

from __future__ import annotations

import math

import numpy as np
import pytest

from endocal.zoom.doubt import GrowingDoubt, doubt_after


def test_it_grows_as_what_it_describes_spreads() -> None:
    rng = np.random.default_rng(2)
    memory, step, frames, speed = 0.7, 0.04, 200, 0.05
    kept = math.exp(-step / memory)
    error, added = rng.normal(0, speed, 4000), np.zeros(4000)
    doubt, variance = GrowingDoubt(memory), 0.0
    for _ in range(frames):
        added += error * step
        variance += doubt.grow(speed, step)
        error = kept * error + math.sqrt(1 - kept**2) * rng.normal(0, speed, 4000)
    # Over 4000 runs a standard deviation is known to 1 %.
    assert math.sqrt(variance) == pytest.approx(added.std(), rel=0.05)


def test_at_first_it_grows_with_time_and_not_with_its_root() -> None:
    doubt = GrowingDoubt(10.0)
    assert sum(doubt.grow(0.1, 0.04) for _ in range(10)) == pytest.approx(0.04**2, rel=0.05)


def test_a_restart_forgets_what_has_added_up() -> None:
    doubt = GrowingDoubt(1.0)
    first = doubt.grow(0.1, 0.04)
    assert doubt.grow(0.1, 0.04) > 2 * first
    doubt.restart()
    assert doubt.grow(0.1, 0.04) == first


@pytest.mark.parametrize("seconds", [0.0, 0.1, 1.0, 30.0])
def test_what_it_comes_to_is_known_beforehand(seconds: float) -> None:
    doubt, steps = GrowingDoubt(0.7), 3000
    variance = sum(doubt.grow(0.1, seconds / steps) for _ in range(steps))
    assert doubt_after(0.1, 0.7, seconds) == pytest.approx(math.sqrt(variance), rel=1e-6)


def test_a_long_step_counts_as_many_short_ones() -> None:
    # Two seconds known to 0.1 per s, three in which the speed is in doubt no more, and two again.
    spans = ((0.1, 2.0), (0.0, 3.0), (0.1, 2.0))
    long, short = GrowingDoubt(0.7), GrowingDoubt(0.7)
    at_once = sum(long.grow(deviation, seconds) for deviation, seconds in spans)
    steps = [(d, s / 100) for d, s in spans for _ in range(100)]
    assert sum(short.grow(d, s) for d, s in steps) == pytest.approx(at_once, rel=1e-6)
