"""The rendered picture against its truth."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from endocal.model import DivisionModel
from endocal.synth.board import (
    BoardScene,
    Overlay,
    plane_coordinates,
    project,
    render_board,
    true_corners,
    true_lines,
    visible,
)
from endocal.synth.camera import Camera, ContentCircle
from endocal.synth.fisheye import Fisheye
from endocal.synth.objects import Highlight, Instrument
from endocal.synth.pattern import Pattern, Pose

SHARP = Camera(blur=0.0)
LENSES = {
    "barrel": DivisionModel(-2.8e-6, (370.3, 262.9), (720, 540)),
    "none": DivisionModel(0.0, (350.0, 280.0), (720, 540)),
    "pincushion": DivisionModel(6e-7, (350.0, 280.0), (720, 540)),
    "two-parameter": DivisionModel(-2e-6, (360.0, 270.0), (720, 540), lam2=-3e-12),
    "fisheye": Fisheye("equidistant", 340.0, (355.0, 262.0), (720, 540)),
    "wide pixels": DivisionModel(-2.2e-6, (355.0, 265.0), (720, 540), pixel_aspect=64 / 45),
}


def scene_of(model: DivisionModel | Fisheye, **changes: object) -> BoardScene:
    pattern = Pattern(cols=11, rows=9, dark=0.2, light=0.8, background=0.4)
    pose = Pose((365.0, 260.0), 42.0, tilt=25, tilt_axis=70, rotation=12, focal=500)
    return replace(BoardScene(model, pattern, pose, camera=SHARP), **changes)


def edge_errors(scene: BoardScene) -> np.ndarray:
    """Measured minus true places, px, of near-vertical edges, from the light that each row of pixels got.

    Between two squares of known grey, the share of dark light in a row of pixels says where the edge is;
    over one pixel's height the edge is straight, so that is its place at the row's middle.
    """
    picture = render_board(scene).astype(float)
    low, high = 255 * scene.pattern.dark, 255 * scene.pattern.light
    errors = []
    for line in true_lines(scene, 4000):
        if abs(line[-1, 0] - line[0, 0]) > abs(line[-1, 1] - line[0, 1]):
            continue
        order = np.argsort(line[:, 1])
        for row in range(int(line[:, 1].min()) + 2, int(line[:, 1].max()) - 2, 3):
            true_x = np.interp(row, line[order, 1], line[order, 0])
            left, right = round(true_x) - 3, round(true_x) + 4
            window = (picture[row, left:right] - low) / (high - low)
            first, last = round(window[0]), round(window[-1])
            plain = abs(window[0] - first) < 0.02 and abs(window[-1] - last) < 0.02
            if first == last or not plain:
                continue
            share = window.sum() if first else (1 - window).sum()
            errors.append(left - 0.5 + share - true_x)
    return np.array(errors)


@pytest.mark.parametrize("lens", LENSES)
def test_edges_lie_where_the_model_puts_them(lens: str) -> None:
    # Rounding to grey levels moves an edge by up to half a level of 153 in a pixel or two, 0.004 px;
    # the sampling adds about as much, without a preferred side.
    errors = edge_errors(scene_of(LENSES[lens]))
    assert len(errors) > 500
    assert abs(errors.mean()) < 0.0005
    assert errors.std() < 0.006
    assert np.abs(errors).max() < 0.03


def test_corners_are_found_where_they_should_be() -> None:
    # cornerSubPix itself is good to a few hundredths of a pixel on blurred, tilted corners.
    scene = scene_of(LENSES["barrel"], camera=Camera(blur=0.8))
    corners, seen = true_corners(scene)
    picture = render_board(scene)
    start = corners[seen].astype(np.float32) + 0.4
    stop = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 50, 1e-3)
    found = cv2.cornerSubPix(picture, start.reshape(-1, 1, 2).copy(), (5, 5), (-1, -1), stop)
    errors = found.reshape(-1, 2) - corners[seen]
    assert seen.all()
    assert np.abs(errors.mean(axis=0)).max() < 0.01
    assert np.sqrt((errors**2).sum(axis=1).mean()) < 0.05


@pytest.mark.parametrize("lens", LENSES)
def test_projection_and_its_inverse_agree_with_the_model(lens: str) -> None:
    scene = scene_of(LENSES[lens])
    plane = scene.pattern.inner_corners()
    seen = project(scene, plane)
    np.testing.assert_allclose(plane_coordinates(scene, seen), plane, atol=1e-9)
    for line in true_lines(scene):
        # Undistorted, in square pixels, the points of a line are straight.
        flat = scene.model.undistort(line) * (scene.model.pixel_aspect, 1.0)
        flat -= flat.mean(axis=0)
        assert np.linalg.svd(flat, compute_uv=False)[1] < 1e-9 * np.linalg.norm(flat)


def test_a_pattern_seen_from_straight_ahead_has_the_stated_squares() -> None:
    model = DivisionModel(0.0, (300.0, 200.0), (640, 480))
    scene = scene_of(model, pose=Pose((310.0, 220.0), 30.0, focal=400))
    corners, _ = true_corners(scene)
    np.testing.assert_allclose(np.diff(corners[..., 0], axis=1), 30.0)
    np.testing.assert_allclose(np.diff(corners[..., 1], axis=0), 30.0)
    np.testing.assert_allclose(corners.mean(axis=(0, 1)), (310.0, 220.0))


def test_a_tilted_plane_ends_at_its_horizon() -> None:
    model = DivisionModel(-1e-6, (319.5, 239.5), (640, 480))
    scene = scene_of(model, pose=Pose((319.5, 239.5), 40.0, tilt=80, tilt_axis=0, focal=100))
    behind = plane_coordinates(scene, np.array([[319.5, 0.0], [319.5, 479.0]]))
    assert np.isnan(behind).any(axis=1).sum() == 1
    # A place behind the camera is seen nowhere.
    assert np.isnan(project(scene, np.array([[0.0, 500.0], [0.0, -500.0]]))).any(axis=1).sum() == 1
    render_board(scene)


def test_bars_have_lines_one_way() -> None:
    scene = scene_of(LENSES["barrel"], pattern=Pattern(kind="lines", cols=9, rows=7))
    assert len(true_lines(scene)) == 8
    levels = scene.pattern.radiances[2:].reshape(7, 9)
    assert (levels == levels[0]).all()
    assert (levels[0, ::2] < levels[0, 1]).all()


def test_the_circle_has_its_diameter_and_center() -> None:
    circle = ContentCircle((341.2, 268.7), 411.3, softness=3.0)
    bright = Pattern(dark=0.9, light=0.9, background=0.9)
    scene = scene_of(LENSES["none"], circle=circle, pattern=bright)
    share = render_board(scene) / (0.9 * 255)
    # Rounding 0.9 * 255 to a whole level is 0.2 % of the area, 0.1 % of the diameter.
    assert abs(2 * np.sqrt(share.sum() / np.pi) - 411.3) < 0.5
    y, x = np.indices(share.shape)
    center = (share * x).sum() / share.sum(), (share * y).sum() / share.sum()
    np.testing.assert_allclose(center, circle.center, atol=0.01)


def test_wide_pixels_make_the_circle_narrow() -> None:
    model = LENSES["wide pixels"]
    bright = Pattern(dark=0.9, light=0.9, background=0.9)
    scene = scene_of(model, circle=ContentCircle((360.0, 270.0), 480.0), pattern=bright)
    lit = render_board(scene) > 128
    assert abs(lit.any(axis=0).sum() - 480 / model.pixel_aspect) <= 2
    assert abs(lit.any(axis=1).sum() - 480) <= 2


def test_noise_has_the_stated_sigma_in_grey() -> None:
    clean = render_board(scene_of(LENSES["barrel"])).astype(float)
    noisy = render_board(scene_of(LENSES["barrel"], camera=Camera(blur=0, noise=5.0)))
    # Over 390,000 pixels the sigma is known to 0.1 %; rounding adds 1/12.
    assert abs((noisy - clean).std() - np.hypot(5.0, np.sqrt(1 / 12))) < 0.05
    tinted = scene_of(LENSES["barrel"], camera=Camera(blur=0, noise=5.0, tint=(1.0, 1.0, 1.0)))
    np.testing.assert_array_equal(cv2.cvtColor(render_board(tinted), cv2.COLOR_BGR2GRAY), noisy)


def test_blur_has_the_stated_sigma_up_to_the_frame_border() -> None:
    model = DivisionModel(0.0, (99.5, 49.5), (200, 100))
    # One edge in the middle of the picture, straight up.
    pattern = Pattern(cols=2, rows=1, dark=0.0, light=1.0)
    pose = Pose((99.5, 49.5), 4000.0, focal=500)
    picture = render_board(BoardScene(model, pattern, pose, camera=Camera(blur=2.0))).astype(float)
    spread = np.diff(picture, axis=1)
    x = np.arange(199) - 99.0
    np.testing.assert_allclose(np.sqrt((spread * x * x).sum(1) / spread.sum(1)), 2.0, atol=0.05)
    np.testing.assert_array_equal(picture[0], picture[50])


def test_gamma_and_black_level() -> None:
    scene = scene_of(LENSES["none"], camera=Camera(blur=0, gamma=2.2, black=16))
    picture = render_board(scene)
    expected = {round(16 + 239 * v ** (1 / 2.2)) for v in (0.2, 0.4, 0.8)}
    levels, counts = np.unique(picture, return_counts=True)
    assert set(levels[np.argsort(counts)[-3:]]) == expected


def test_vignetting_darkens_towards_the_rim() -> None:
    camera = Camera(blur=0, vignetting=0.8, vignetting_radius=200.0)
    bright = Pattern(dark=0.5, light=0.5, background=0.5)
    circle = ContentCircle((350.0, 280.0), 400.0)
    picture = render_board(scene_of(LENSES["none"], camera=camera, pattern=bright, circle=circle))
    assert picture[280, 350] == 128
    assert abs(int(picture[280, 350 + 190]) - 127.5 * (1 - 0.8 * 0.95**2)) <= 1


def test_fields_of_a_comb_lie_on_either_side_of_the_truth() -> None:
    scene = scene_of(LENSES["none"], comb=(3.0, 0.0))
    woven, still = render_board(scene), render_board(replace(scene, comb=(0.0, 0.0)))
    for field, shift in ((woven[0::2], -1.5), (woven[1::2], 1.5)):
        moved = replace(LENSES["none"], center=(350.0 + shift, 280.0))
        pose = replace(scene.pose, center=(scene.pose.center[0] + shift, scene.pose.center[1]))
        alone = render_board(replace(scene, model=moved, pose=pose, comb=(0.0, 0.0)))
        rows = slice(0, None, 2) if shift < 0 else slice(1, None, 2)
        # In single precision a sample here and there falls on the other side of an edge.
        assert np.abs(field.astype(int) - alone[rows]).max() <= 3
    assert (woven != still).mean() > 0.02


def test_what_is_hidden_is_not_counted_as_visible() -> None:
    circle = ContentCircle((360.0, 270.0), 380.0)
    shaft = Instrument(tip=(-0.12, -0.02), angle=30, width=0.08, radiance=0.02, shine=0.02)
    scene = scene_of(LENSES["barrel"], circle=circle, instruments=(shaft,))
    picture = render_board(scene)
    seen = visible(scene, np.stack(np.meshgrid(np.arange(720), np.arange(540)), -1).astype(float))
    y, x = np.indices(seen.shape)
    near_rim = np.abs(np.hypot(x - 360, y - 270) - 190) < 2
    dark = picture < 20
    # Every pixel darker than the pattern's darkest is hidden; edges of the shaft may go either way.
    assert ((dark == ~seen) | near_rim).mean() > 0.995
    assert not seen[310, 404]


def test_highlights_saturate_and_text_is_burnt_in() -> None:
    spot = Highlight((300.0, 200.0), 10.0, 2.0)
    scene = scene_of(
        LENSES["barrel"], highlights=(spot,), overlays=(Overlay("REC", (5, 530), 1.0, level=200),)
    )
    picture, plain = render_board(scene), render_board(scene_of(LENSES["barrel"]))
    assert picture[200, 300] == 255
    changed = np.argwhere(picture != plain)
    near_spot = np.hypot(changed[:, 1] - 300, changed[:, 0] - 200) <= 60
    text = changed[~near_spot]
    assert len(text) > 100
    assert text[:, 0].min() > 490
    assert text[:, 1].max() < 120
    assert (picture[tuple(text.T)] >= 60).all()


def test_the_same_seed_gives_the_same_bytes() -> None:
    camera = Camera(noise=3, jpeg=90, tint=(0.8, 0.9, 1.0))
    scene = scene_of(LENSES["barrel"], camera=camera, clutter=0.4, seed=7)
    first = render_board(scene)
    np.testing.assert_array_equal(first, render_board(scene))
    assert (first != render_board(replace(scene, seed=8))).any()
    assert first.dtype == np.uint8
    assert first.shape == (540, 720, 3)
