"""A recording that begins without a visible circle: the first one holds, in doubt, until it is seen."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pytest

from endocal.errors import InputError
from endocal.jobs.first_circle import first_circle
from endocal.jobs.zoom_log import ZoomRecord
from endocal.jobs.zoom_source import FollowedZoom
from endocal.zoom.table import Setting, ZoomTable

SIZE = (320, 240)
CENTER = ((SIZE[0] - 1) / 2, (SIZE[1] - 1) / 2)
TABLE = ZoomTable(
    tuple(Setting(-0.8 / d**2, CENTER, d, circle=CENTER) for d in (150.0, 500.0)), SIZE
)
# Wider than the frame's diagonal of 400 px, and then in sight.
DIAMETERS = np.geomspace(500, 300, 60)


def scene(diameter: float) -> np.ndarray:
    """A textured wall seen through a rim of this diameter, px; the texture grows with it: uint8 (h, w)."""
    y, x = np.mgrid[: SIZE[1], : SIZE[0]].astype(np.float64)
    x, y = (x - CENTER[0]) / diameter, (y - CENTER[1]) / diameter
    light = 140 + 30 * (np.sin(61 * x + 9 * y) + np.cos(53 * y - 17 * x * y) + np.sin(140 * x * y))
    rim = np.clip(0.5 + diameter / 2 - diameter * np.hypot(x, y), 0, 1)
    return np.asarray((rim * light).clip(0, 255).astype(np.uint8))


class Records(list[ZoomRecord]):
    """A log in memory."""

    def add(self, record: ZoomRecord) -> None:
        self.append(record)


def follow(diameters: np.ndarray, times: list[float | None]) -> tuple[Records, FollowedZoom]:
    def ahead() -> Iterator[tuple[np.ndarray, float | None]]:
        return ((scene(d), time) for d, time in zip(diameters, times, strict=True))

    log = Records()
    zoom = FollowedZoom(TABLE, "auto", "auto", None, None, log, ahead)
    for luma, time in ahead():
        zoom.model(lambda luma=luma: luma, time)
    return log, zoom


def test_it_holds_without_a_step_until_the_rim_is_seen() -> None:
    log, zoom = follow(DIAMETERS, [i / 25 for i in range(len(DIAMETERS))])
    sources = [record.source for record in log]
    seen = sources.index("rim")
    assert 10 < seen < 50
    assert sources[:seen] == ["held"] * seen
    assert len({record.diameter for record in log[:seen]}) == 1
    # The rim that is seen rules at once: no waiting, nothing carried over.
    assert [r.diameter for r in log[seen : seen + 3]] == pytest.approx(
        DIAMETERS[seen : seen + 3], rel=0.01
    )
    assert "first frames show no circle" in zoom.notes[0]


@pytest.mark.parametrize("timed", [True, False])
def test_its_doubt_grows_towards_the_start_and_covers_the_truth(timed: bool) -> None:
    times = [i / 25 if timed else None for i in range(len(DIAMETERS))]
    log, _ = follow(DIAMETERS, times)
    doubts = [r.uncertainty for r in log if r.source == "held"]
    # One circle in four frames is looked at, so that the very last ones may lie behind the first.
    assert all(a > b for a, b in pairwise(doubts[:-3]))
    assert doubts[0] > 4 * doubts[-1]
    for record, diameter in zip(log[: len(doubts)], DIAMETERS, strict=False):
        assert abs(math.log(record.diameter / diameter)) < 4 * record.uncertainty


@pytest.mark.parametrize("false", [160.0, 260.0])
def test_a_single_false_circle_decides_nothing(false: float) -> None:
    # In the ninth frame, which is looked at: something round and dark about the view, as a trocar's mouth.
    diameters = np.concatenate([np.full(8, 900.0), [false], np.full(7, 900.0), np.full(12, 320.0)])
    log, _ = follow(diameters, [None] * len(diameters))
    assert [record.source for record in log] == ["held"] * 16 + ["rim"] * 12
    assert [record.diameter for record in log] == pytest.approx([320.0] * 28, rel=0.01)


def test_a_circle_that_nothing_confirms_is_taken_where_the_video_ends() -> None:
    videos = [(scene(d), None) for d in [900.0] * 4 + [320.0]]
    assert first_circle(lambda: iter(videos), TABLE, "auto", True).number == 4


def test_a_video_without_any_circle_is_refused() -> None:
    with pytest.raises(InputError, match="no frame shows a visible circle"):
        follow(np.full(6, 900.0), [None] * 6)


def test_a_pipe_cannot_be_searched_and_only_its_first_frame_is_blamed() -> None:
    zoom = FollowedZoom(TABLE, "auto", "auto", None, None, None, lambda: iter(()))
    with pytest.raises(InputError, match="the first frame does not show a visible circle"):
        zoom.model(lambda: scene(900.0), None)
