"""The scale between two frames against motions that are known exactly."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from endocal.benchmarks.rim_frames import texture
from endocal.model import DivisionModel
from endocal.zoom.table import Setting, ZoomTable
from endocal.zoom.track import ScaleTracker, TrackingSpec, scale_between

SIZE = (640, 480)
MIDDLE = (325.0, 236.0)
DIAMETER = 900.0
STRENGTH = -1.3


def model(diameter: float = DIAMETER) -> DivisionModel:
    return DivisionModel(STRENGTH / diameter**2, MIDDLE, SIZE)


def places(seed: int, count: int = 150) -> np.ndarray:
    """Places all over the frame, px."""
    return np.random.default_rng(seed).uniform((10, 10), (630, 470), (count, 2))


def moved(
    before: np.ndarray, logarithm: float, matrix: np.ndarray, depth: np.ndarray | None = None
) -> np.ndarray:
    """Zoom after the undistorted picture was moved by a homography, in units of the diameter."""
    u = (model().undistort(before) - MIDDLE) / DIAMETER
    ones = np.ones((len(u), 1))
    v = np.hstack([u, ones]) @ matrix.T
    v = v[:, :2] / v[:, 2:]
    after = model().distort(v * DIAMETER + MIDDLE)
    return (after - MIDDLE) * math.exp(logarithm) + MIDDLE


def camera(shift: tuple[float, float], turn: float, nearer: float, tilt: float) -> np.ndarray:
    """A homography of the undistorted picture."""
    c, s = math.cos(turn), math.sin(turn)
    return np.array(
        [
            [(1 + nearer) * c, -(1 + nearer) * s, shift[0]],
            [(1 + nearer) * s, (1 + nearer) * c, shift[1]],
            [tilt, -tilt, 1.0],
        ]
    )


@given(
    logarithm=st.floats(-0.02, 0.02),
    shift=st.tuples(st.floats(-0.01, 0.01), st.floats(-0.01, 0.01)),
    turn=st.floats(-0.01, 0.01),
    nearer=st.floats(-0.008, 0.008),
    seed=st.integers(0, 50),
)
def test_a_zoom_is_told_from_a_camera_that_comes_nearer(
    logarithm: float, shift: tuple[float, float], turn: float, nearer: float, seed: int
) -> None:
    before = places(seed)
    after = moved(before, logarithm, camera(shift, turn, nearer, 0.002))
    after += np.random.default_rng(seed).normal(0, 0.05, after.shape)
    step = scale_between(before - MIDDLE, after - MIDDLE, model(), DIAMETER, noise=0.05)
    # The motion is linearised: what is left of it is of second order. The rest is noise, as stated.
    second_order = 2 * (abs(logarithm) + abs(nearer) + abs(turn) + max(map(abs, shift))) ** 2
    assert abs(step.logarithm - logarithm) < 5 * step.sigma + second_order


def test_without_distortion_the_expected_motion_is_believed() -> None:
    # Nothing tells the two apart: the zoom, of which five times as much is expected, gets 25 of 26 parts.
    straight = DivisionModel(0.0, MIDDLE, SIZE)
    before = places(1) - MIDDLE
    spec = TrackingSpec(zoom=0.02, approach=0.004)
    step = scale_between(before, before * math.exp(0.01), straight, DIAMETER, spec=spec)
    assert step.logarithm == pytest.approx(0.01 * 25 / 26, rel=0.02)
    assert step.sigma > 0.003


def test_things_that_move_on_their_own_are_left_out() -> None:
    before = places(2)
    after = moved(before, 0.01, camera((0.002, 0), 0, 0, 0))
    after[:45] = before[:45] + np.array([9.0, -4.0])
    step = scale_between(before - MIDDLE, after - MIDDLE, model(), DIAMETER)
    assert step.logarithm == pytest.approx(0.01, abs=5e-4)


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
