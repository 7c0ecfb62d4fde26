"""What goes by between frames."""

from __future__ import annotations

import pytest

from endocal.zoom.clock import USUAL_STEP, Elapsed, FrameClock


def frames(times: list[float | None]) -> list[float]:
    clock = FrameClock()
    return [clock.tick(t)[0].frames for t in times]


def test_times_rounded_to_milliseconds_are_those_of_one_frame() -> None:
    assert frames([0.0, 0.033, 0.067, 0.1, 0.133, 0.167]) == [1.0] * 6
    assert frames([0.0, 0.008, 0.017, 0.025, 0.033, 0.042]) == [1.0] * 6


def test_a_dropped_frame_counts() -> None:
    assert frames([0.0, 0.04, 0.08, 0.16, 0.2]) == pytest.approx([1, 1, 1, 2, 1])


def test_without_times_and_where_they_do_not_advance_one_frame_goes_by() -> None:
    assert frames([None] * 4) == [1.0] * 4
    clock = FrameClock()
    assert clock.tick(None)[0] == Elapsed(1.0, USUAL_STEP)
    assert clock.tick(1.0)[0] == Elapsed(1.0, USUAL_STEP)
    clock.tick(1.5)
    assert clock.tick(1.5)[0] == Elapsed(1.0, 0.5)
    assert clock.tick(0.5)[0] == Elapsed(1.0, 0.5)


def test_another_frame_rate_is_taken_up_and_told() -> None:
    clock = FrameClock()
    times = [0.04 * i for i in range(20)] + [0.8 + 0.02 * i for i in range(20)]
    ticks = [clock.tick(t) for t in times]
    assert [e.frames for e, _ in ticks[:20]] == [1.0] * 20
    assert ticks[23][0].frames == pytest.approx(0.5)
    assert [e.frames for e, _ in ticks[-8:]] == [1.0] * 8
    assert [c for _, c in ticks if c != 1.0] == [pytest.approx(0.5)]
