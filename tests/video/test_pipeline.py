"""Three stages at once: order, bounds, and every way to end."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator

import pytest

from endocal.video.pipeline import QUEUE_DEPTH, run


def pipeline_threads() -> list[str]:
    return [t.name for t in threading.enumerate() if t.name.startswith("endocal-")]


def test_items_come_out_in_order_and_changed() -> None:
    out: list[int] = []
    run(range(100), lambda n: n * n, out.append)
    assert out == [n * n for n in range(100)]
    assert pipeline_threads() == []


def test_nothing_in_is_nothing_out() -> None:
    out: list[int] = []
    run([], lambda n: n, out.append)
    assert out == []


def test_the_source_does_not_run_ahead() -> None:
    """Memory is bounded: two queues, and one item in the hands of each of the three stages."""
    started = 0
    finished = 0
    worst = 0

    def source() -> Iterator[int]:
        nonlocal started
        for i in range(60):
            started += 1
            yield i

    def sink(item: int) -> None:
        nonlocal finished, worst
        time.sleep(0.001)
        worst = max(worst, started - finished)
        finished += 1

    run(source(), lambda n: n, sink)
    assert finished == 60
    assert worst <= 2 * QUEUE_DEPTH + 3


def test_small_items_take_no_room() -> None:
    """A hundred small items go before a large one although the queues are short."""
    out: list[str] = []
    gate = threading.Event()

    def source() -> Iterator[str]:
        yield from ["small"] * 100
        gate.set()
        yield "large"

    def sink(item: str) -> None:
        assert gate.wait(10), "the source was held up by small items"
        out.append(item)

    run(source(), lambda s: s, sink, is_large=lambda s: s == "large")
    assert out == ["small"] * 100 + ["large"]


@pytest.mark.parametrize("stage", ["source", "change", "sink"])
def test_an_error_in_any_stage_ends_all_and_is_raised(stage: str) -> None:
    def fail(where: str, item: int) -> int:
        if where == stage and item == 5:
            raise ValueError(where)
        return item

    with pytest.raises(ValueError, match=stage):
        run(
            (fail("source", n) for n in range(1000)),
            lambda n: fail("change", n),
            lambda n: fail("sink", n) and None,
        )
    assert pipeline_threads() == []


def test_an_interrupt_wakes_a_source_that_waits() -> None:
    woken = threading.Event()

    def source() -> Iterator[int]:
        yield 1
        assert woken.wait(10)

    ticks = 0

    def tick() -> None:
        nonlocal ticks
        ticks += 1
        if ticks == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(source(), lambda n: n, lambda n: None, tick=tick, tick_s=0.01, on_stop=woken.set)
    assert woken.is_set()
    assert pipeline_threads() == []


def test_stages_overlap() -> None:
    """Each stage meets the others at a barrier that none of them could pass alone."""
    barrier = threading.Barrier(3, timeout=10)

    def source() -> Iterator[int]:
        yield from (1, 2)
        barrier.wait()
        yield 3

    def change(item: int) -> int:
        if item == 2:
            barrier.wait()
        return item

    def sink(item: int) -> None:
        if item == 1:
            barrier.wait()

    run(source(), change, sink)
