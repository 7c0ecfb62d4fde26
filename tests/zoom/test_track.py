"""The zoom tracked through pictures whose scale is known."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace

import cv2
import numpy as np
import pytest

from endocal.benchmarks.rim_frames import texture
from endocal.zoom.table import Setting, ZoomTable
from endocal.zoom.track import ScaleTracker

SIZE = (640, 480)
MIDDLE = (325.0, 236.0)
# From there the shift of one test leads to the middle.
FAR = (MIDDLE[0] - 9.0, MIDDLE[1] + 6.0)
DIAMETER = 900.0
STRENGTH = -1.3


TABLE = ZoomTable(tuple(Setting(STRENGTH / d**2, MIDDLE, d) for d in (600.0, 1200.0)), SIZE)


def zoomed(speed: float, count: int) -> Iterator[np.ndarray]:
    """Frames of a zoom that magnifies a texture about the centre, where its middle lies."""
    rng = np.random.default_rng(5)
    scene = (255 * texture(rng, (960, 720), 1.2)).astype(np.uint8)
    for i in range(count):
        scale = math.exp(speed * i)
        matrix = np.array(
            [[scale, 0, MIDDLE[0] - scale * 480], [0, scale, MIDDLE[1] - scale * 360]]
        )
        yield cv2.warpAffine(scene, matrix, SIZE, flags=cv2.INTER_AREA).astype(np.uint8)


def tracked(frames: Iterable[np.ndarray]) -> float:
    """The logarithm of the zoom over all frames, as the tracker has it."""
    tracker = ScaleTracker()
    total, diameter = 0.0, DIAMETER
    for i, frame in enumerate(frames):
        step = tracker.step(frame, TABLE, diameter)
        assert (step is None) == (i == 0)
        if step is not None:
            total += step.logarithm
            diameter *= math.exp(step.logarithm)
    return total


def test_a_zoomed_texture_is_followed() -> None:
    # The prior takes a little, since a nearing camera is not impossible.
    assert tracked(zoomed(0.01, 16)) == pytest.approx(15 * 0.01, rel=0.03)


def test_soft_tissue_is_followed_beside_highlights_and_an_instrument() -> None:
    # They stand still, and their corners are thousands of times as strong as the tissue's.
    def dressed(frame: np.ndarray) -> np.ndarray:
        soft = cv2.GaussianBlur(frame, (0, 0), 3) // 2 + 60
        for x, y in ((80, 90), (420, 60), (560, 380), (200, 400)):
            cv2.circle(soft, (x, y), 7, (255,), -1)
        cv2.rectangle(soft, (0, 200), (180, 240), (10,), -1)
        return soft

    assert tracked(dressed(f) for f in zoomed(0.01, 16)) == pytest.approx(15 * 0.01, rel=0.05)


@pytest.mark.parametrize("brightest", [256, 512, 1024, 4096])
def test_light_that_flickers_about_a_power_of_two_hides_nothing(brightest: int) -> None:
    frames = (
        (frame / frame.max() * brightest * (0.98 if i % 2 == 0 else 1.02)).astype(np.uint16)
        for i, frame in enumerate(zoomed(0.01, 10))
    )
    assert tracked(frames) == pytest.approx(9 * 0.01, rel=0.1)


@pytest.mark.parametrize("level", [0, 128, 255])
def test_an_even_picture_tells_nothing(level: int) -> None:
    tracker = ScaleTracker()
    frame = np.full((480, 640), level, np.uint8)
    assert [tracker.step(frame, TABLE, DIAMETER) for _ in range(3)] == [None] * 3


def test_a_shift_is_that_of_the_table_s_centres() -> None:
    shift = (9.0, -6.0)
    moved = replace(TABLE, settings=tuple(replace(s, center=FAR) for s in TABLE.settings))
    here, there = ScaleTracker(), ScaleTracker()
    for frame in zoomed(0.01, 4):
        step = here.step(frame, moved, DIAMETER, shift=shift)
        same = there.step(frame, TABLE, DIAMETER)
        assert (step is None) == (same is None)
        if step is not None and same is not None:
            assert step.logarithm == pytest.approx(same.logarithm, rel=1e-9)
    assert step is not None
