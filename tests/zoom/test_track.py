"""The zoom tracked through pictures whose scale is known."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from endocal.benchmarks.rim_frames import texture
from endocal.zoom.table import Setting, ZoomTable
from endocal.zoom.track import ScaleTracker

SIZE = (640, 480)
MIDDLE = (325.0, 236.0)
DIAMETER = 900.0
STRENGTH = -1.3


def test_a_zoomed_texture_is_followed() -> None:
    rng = np.random.default_rng(5)
    scene = (255 * texture(rng, (960, 720), 1.2)).astype(np.uint8)
    zoom = ZoomTable(tuple(Setting(STRENGTH / d**2, MIDDLE, d) for d in (600.0, 1200.0)), SIZE)
    tracker = ScaleTracker()
    total, speed, diameter = 0.0, 0.01, DIAMETER
    for i in range(16):
        # The zoom magnifies the frame about the centre; the scene's middle lies there.
        scale = math.exp(speed * i)
        matrix = np.array(
            [[scale, 0, MIDDLE[0] - scale * 480], [0, scale, MIDDLE[1] - scale * 360]]
        )
        frame = cv2.warpAffine(scene, matrix, SIZE, flags=cv2.INTER_AREA)
        step = tracker.step(np.asarray(frame, np.uint8), zoom, diameter)
        assert (step is None) == (i == 0)
        if step is not None:
            total += step.logarithm
            diameter *= math.exp(step.logarithm)
    # The prior takes a little, since a nearing camera is not impossible.
    assert total == pytest.approx(15 * speed, rel=0.03)


@pytest.mark.parametrize("level", [0, 128, 255])
def test_an_even_picture_tells_nothing(level: int) -> None:
    zoom = ZoomTable(tuple(Setting(STRENGTH / d**2, MIDDLE, d) for d in (600.0, 1200.0)), SIZE)
    tracker = ScaleTracker()
    frame = np.full((480, 640), level, np.uint8)
    assert [tracker.step(frame, zoom, DIAMETER) for _ in range(3)] == [None] * 3
