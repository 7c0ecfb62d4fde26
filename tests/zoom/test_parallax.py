"""A zoom told from a moving camera, against motions that are known exactly."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from endocal.model import DivisionModel
from endocal.zoom.parallax import MotionSpec, SceneShape

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
    step = SceneShape().scale_between(
        before - MIDDLE, after - MIDDLE, model(), DIAMETER, noise=0.05
    )
    # The motion is linearised: what is left of it is of second order. The rest is noise, as stated.
    second_order = 2 * (abs(logarithm) + abs(nearer) + abs(turn) + max(map(abs, shift))) ** 2
    assert abs(step.logarithm - logarithm) < 5 * step.sigma + second_order


def test_without_distortion_the_expected_motion_is_believed() -> None:
    # Nothing tells the two apart: the zoom, of which five times as much is expected, gets 25 of 26 parts.
    straight = DivisionModel(0.0, MIDDLE, SIZE)
    before = places(1) - MIDDLE
    scene = SceneShape(MotionSpec(zoom=0.02, approach=0.004))
    step = scene.scale_between(before, before * math.exp(0.01), straight, DIAMETER)
    assert step.logarithm == pytest.approx(0.01 * 25 / 26, rel=0.02)
    assert step.sigma > 0.003


def test_things_that_move_on_their_own_are_left_out() -> None:
    before = places(2)
    after = moved(before, 0.01, camera((0.002, 0), 0, 0, 0))
    after[:45] = before[:45] + np.array([9.0, -4.0])
    step = SceneShape().scale_between(before - MIDDLE, after - MIDDLE, model(), DIAMETER)
    assert step.logarithm == pytest.approx(0.01, abs=5e-4)


@pytest.mark.parametrize("speed", [0.0, 0.006])
def test_in_a_cavity_a_camera_that_comes_nearer_is_not_taken_for_a_zoom(speed: float) -> None:
    # Walls that come nearer towards the rim: without their shape, half the approach passes for zoom.
    rng = np.random.default_rng(4)
    focal, frames, approach = 0.55 * DIAMETER, 50, 0.12
    x, y = rng.uniform(-0.8, 0.8, (2, 400))
    places_3d = np.stack([x, y, 1 - 0.5 * (x * x + y * y)], axis=1)

    def seen(frame: int) -> np.ndarray:
        """Offsets from the centre at the diameter of the first frame, before the zoom."""
        along = frame / frames
        eye = np.array([0.03 * math.sin(6 * along), 0.03 * math.cos(5 * along), approach * along])
        ray = places_3d - eye
        undistorted = focal * ray[:, :2] / ray[:, 2:] + MIDDLE
        return model().distort(undistorted) - MIDDLE

    scene, total, late = SceneShape(), 0.0, 0.0
    for frame in range(1, frames):
        before, after = seen(frame - 1), seen(frame) * math.exp(speed)
        inside = (np.abs(before) < (320, 240)).all(axis=1)
        after = after + rng.normal(0, 0.05, after.shape)
        step = scene.scale_between(before[inside], after[inside], model(), DIAMETER, noise=0.05)
        total += step.logarithm - speed
        late += (step.logarithm - speed) * (frame > frames // 2)
    # The sway shows the shape, so that little of the approach is left to mistake.
    assert abs(total) < 0.15 * approach
    assert abs(late) < 0.05 * approach


@pytest.mark.parametrize("logarithm", [-0.18, -0.1, 0.1, 0.18])
def test_a_zoom_that_jumps_from_rest_is_followed(logarithm: float) -> None:
    scene, hand, rng = (
        SceneShape(),
        camera((0.004, -0.003), 0.0, 0.0, 0.0),
        np.random.default_rng(7),
    )
    for seed in range(6):
        before = places(seed)
        jump = logarithm if seed == 5 else 0.0
        after = moved(before, jump, hand) + rng.normal(0, 0.05, before.shape)
        step = scene.scale_between(
            before - MIDDLE, after - MIDDLE, model(), DIAMETER, noise=0.05, rests=True, hand=0.003
        )
    assert step.logarithm == pytest.approx(logarithm, abs=0.002)
    assert step.curved < 0.1


def test_what_no_zoom_explains_is_none() -> None:
    # Two thirds of the picture move on their own, some one way and some the other.
    scene, rng = SceneShape(), np.random.default_rng(7)
    for seed in range(6):
        before = places(seed)
        after = before + rng.normal(0, 0.05, before.shape)
        if seed == 5:
            after[:50] += np.array([9.0, -4.0])
            after[50:100] -= np.array([3.0, 7.0])
        step = scene.scale_between(
            before - MIDDLE, after - MIDDLE, model(), DIAMETER, noise=0.05, rests=True, hand=0.003
        )
    assert abs(step.logarithm) < 0.003


def test_a_zoom_under_way_before_the_scene_is_known_is_no_curved_scene() -> None:
    scene, rng = SceneShape(), np.random.default_rng(7)
    for seed in range(4):
        before = places(seed)
        after = moved(before, 0.035, camera((0.004, -0.003), 0.0, 0.0, 0.0))
        after += rng.normal(0, 0.05, before.shape)
        step = scene.scale_between(
            before - MIDDLE, after - MIDDLE, model(), DIAMETER, noise=0.05, rests=True, hand=0.003
        )
        assert step.logarithm == pytest.approx(0.035, rel=0.1)
    assert step.curved < 0.1


def test_errors_that_neighbours_share_leave_more_open_than_errors_of_their_own() -> None:
    rng, sigmas = np.random.default_rng(4), []
    for shared in (False, True):
        scene = SceneShape()
        for seed in range(10):
            before = places(seed)
            # Half a pixel each way: of each place, or of all within a fifth of the picture's sides.
            patch = (before // (SIZE[0] / 5, SIZE[1] / 5)).astype(int) @ (1, 10)
            each = rng.normal(0, 0.5, (100, 2))[patch] if shared else rng.normal(0, 0.5, (150, 2))
            after = moved(before, 0.01, camera((0.003, 0.0), 0.0, 0.0, 0.0)) + each
            step = scene.scale_between(before - MIDDLE, after - MIDDLE, model(), DIAMETER)
        sigmas.append(step.sigma)
    assert sigmas[1] > 1.2 * sigmas[0]


def test_errors_that_last_are_told_from_noise() -> None:
    lasting = []
    for lasts in (False, True):
        rng, scene = np.random.default_rng(4), SceneShape()
        before = places(0)
        patch = (before // (SIZE[0] / 4, SIZE[1] / 3)).astype(int) @ (1, 4)
        each = rng.normal(0, 0.5, (100, 2))
        for _ in range(20):
            noise = rng.normal(0, 0.5, (150, 2)) + (each[patch] if lasts else 0.0)
            after = moved(before, 0.01, camera((0.003, 0.0), 0.0, 0.0, 0.0)) + noise
            step = scene.scale_between(before - MIDDLE, after - MIDDLE, model(), DIAMETER)
        lasting.append(step.lasting)
    assert lasting[0] < 0.3
    assert lasting[1] == 1.0


@pytest.mark.parametrize("deep", [0.0, 0.5])
def test_a_scene_that_is_curved_is_told_from_a_plane(deep: float) -> None:
    rng, focal = np.random.default_rng(4), 0.55 * DIAMETER
    x, y = rng.uniform(-0.8, 0.8, (2, 400))
    places_3d = np.stack([x, y, 1 - 0.1 * x - deep * (x * x + y * y)], axis=1)

    def seen(frame: int) -> np.ndarray:
        """Offsets from the centre, by a hand that sways."""
        ray = places_3d - [0.05 * math.sin(0.12 * frame), 0.05 * math.cos(0.1 * frame), 0.0]
        undistorted = focal * ray[:, :2] / ray[:, 2:] + MIDDLE
        return model().distort(undistorted) - MIDDLE

    scene = SceneShape()
    for frame in range(1, 60):
        before, after = seen(frame - 1), seen(frame)
        inside = (np.abs(before) < (320, 240)).all(axis=1)
        after = after + rng.normal(0, 0.05, after.shape)
        step = scene.scale_between(before[inside], after[inside], model(), DIAMETER, noise=0.05)
    assert step.curved > 0.3 if deep else step.curved < 0.1
