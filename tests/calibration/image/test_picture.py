from pathlib import Path

import cv2
import numpy as np
import pytest

from endocal import calibrate
from endocal.boundary.circle import Boundary
from endocal.calibration.image.content import content_mask, content_masks
from endocal.calibration.image.edges import (
    edge_directions,
    find_edges,
    find_edges_apart,
    sobel_gradients,
)
from endocal.calibration.image.picture import Picture, field_shift, fields, to_grey
from endocal.errors import InputError
from endocal.files import read_image
from endocal.model import DivisionModel
from endocal.synth.board import BoardScene, render_board
from endocal.synth.camera import Camera, ContentCircle
from endocal.synth.pattern import Pattern, Pose

from ..scenes import board


def test_deep_and_coloured_pictures_become_grey_levels() -> None:
    grey = np.full((80, 90), 200, np.uint8)
    assert to_grey(grey).max() == 200
    assert to_grey(np.full((80, 90), 200 * 257, np.uint16)).max() == pytest.approx(200, abs=0.01)
    assert to_grey(np.full((80, 90, 3), 77, np.uint8)).shape == (80, 90)
    with pytest.raises(InputError, match="float64"):
        to_grey(np.zeros((80, 90)))  # type: ignore[arg-type]
    with pytest.raises(InputError, match="64 px"):
        to_grey(np.zeros((1, 1), np.uint8))


@pytest.mark.parametrize("bits", [10, 12, 14, 16])
def test_bits_that_a_camera_leaves_empty_do_not_count(bits: int) -> None:
    ramp = np.linspace(0, 2**bits - 1, 80 * 90).astype(np.uint16).reshape(80, 90)
    assert to_grey(ramp) == pytest.approx(np.linspace(0, 255, 80 * 90).reshape(80, 90), abs=0.3)


def test_pictures_as_other_libraries_give_them() -> None:
    rng = np.random.default_rng(0)
    colour = rng.integers(0, 65536, (80, 90, 3)).astype(np.uint16)
    expected = to_grey(colour)
    np.testing.assert_array_equal(to_grey(colour.astype(">u2")), expected)
    np.testing.assert_array_equal(to_grey(np.dstack([colour, colour[..., 0]])), expected)
    np.testing.assert_array_equal(to_grey(colour[::-1, ::-1])[::-1, ::-1], expected)
    np.testing.assert_array_equal(to_grey(colour[..., :1]), to_grey(colour[..., 0]))


@pytest.mark.parametrize(
    "shape", [(0,), (6400,), (80, 90, 0), (80, 90, 2), (80, 90, 5), (2, 80, 90, 3), ()]
)
def test_arrays_that_are_no_picture(shape: tuple[int, ...]) -> None:
    odd = np.zeros(shape, np.uint8)
    with pytest.raises(InputError, match=r"is needed, \(h, w\) grey or \(h, w, 3\) BGR"):
        calibrate(odd)
    with pytest.raises(InputError):
        calibrate([np.zeros((80, 90), np.uint8), odd])


@pytest.mark.parametrize("shift", [-3.0, 1.0])
def test_fields_taken_apart_are_seen_and_split(shift: float) -> None:
    grey = to_grey(render_board(board(comb=(shift, 0.0), lam=0.0, center=(319.5, 239.5))))
    assert field_shift(grey) * np.sign(shift) > 0.3
    even, odd = fields(grey)
    np.testing.assert_array_equal(even[::2], grey[::2])
    np.testing.assert_array_equal(odd[1::2], grey[1::2])
    assert abs(field_shift(even)) < 0.05


def test_bands_of_a_large_picture_tell_as_much_as_all_of_it() -> None:
    drawn = render_board(board(comb=(1.0, 0.0), lam=0.0, center=(319.5, 239.5)))
    grey = to_grey(drawn)
    # An odd number of rows, as many as no band has.
    large = np.pad(np.tile(grey, (5, 5)), ((0, 3), (0, 0)), mode="edge")
    assert field_shift(large) == pytest.approx(field_shift(grey), rel=0.05)


def test_a_progressive_noisy_picture_stays_whole() -> None:
    grey = to_grey(render_board(board(noise=10.0)))
    assert abs(field_shift(grey)) < 0.1
    assert len(fields(grey)) == 1


def test_edges_lie_on_the_edge_to_sub_pixel() -> None:
    y, x = np.mgrid[0:200, 0:240]
    radius = np.hypot(x - 118.3, y - 97.6)
    grey = (40 + 160 / (1 + np.exp((radius - 60.25) / 0.8))).astype(np.float32)
    edges = find_edges(Picture(grey, np.ones(grey.shape, bool)))
    distance = np.linalg.norm(edges.points - (118.3, 97.6), axis=1)
    assert len(edges) > 300
    # Smoothing by 1.5 px pulls a circle of 60 px in by sigma^2 / 2R = 0.02 px; the parabola adds a twentieth.
    assert abs(np.mean(distance) - 60.25) < 0.04
    assert np.std(distance) < 0.06
    inward = (edges.gradients * (edges.points - (118.3, 97.6))).sum(axis=1) / distance
    assert np.all(inward < -0.99)


def test_the_big_sobel_mask_gives_the_gradients_direction() -> None:
    y, x = np.mgrid[0:101, 0:101].astype(np.float32)
    grey = np.float32(2) * x + np.float32(3) * y
    g = sobel_gradients(grey, np.array([[50.0, 50.0], [40.2, 60.7]]), 21)
    np.testing.assert_allclose(g[:, 1] / g[:, 0], 1.5, rtol=1e-3)


def test_an_edge_has_one_direction_and_a_crossing_has_none() -> None:
    y, x = np.mgrid[0:101, 0:101].astype(np.float32)
    angle = np.deg2rad(33.0)
    across = (x - 50) * np.cos(angle) + (y - 50) * np.sin(angle)
    along = (y - 50) * np.cos(angle) - (x - 50) * np.sin(angle)
    at = np.array([[50.0, 50.0]])
    edge = (100 * np.tanh(across)).astype(np.float32)
    normal, one_direction = edge_directions(edge, at, 21)
    assert abs(normal[0] @ (np.cos(angle), np.sin(angle))) > 1 - 1e-5  # 0.3 degrees
    assert one_direction[0] > 0.99
    crossing = (100 * np.tanh(across) * np.tanh(along)).astype(np.float32)
    assert edge_directions(crossing, at, 21)[1][0] < 0.1


def test_rim_surround_and_frame_are_no_scene() -> None:
    circle = ContentCircle((330.0, 236.0), 400.0, 2.0)
    grey = to_grey(render_board(board(circle=circle, square=30.0)))
    mask = content_mask(grey, Boundary((330.0, 236.0), 400.0, 1.0, 1.0))
    y, x = np.mgrid[0:480, 0:640]
    radius = np.hypot(x - 330, y - 236)
    assert not mask[radius > 196].any()
    assert mask[radius < 180].mean() > 0.95
    # Without the circle the dark around it tells the same.
    assert not content_mask(grey, None)[radius > 199].any()


def test_the_surround_of_a_large_picture_is_told_as_well() -> None:
    y, x = np.mgrid[0:2101, 0:2803]
    radius = np.hypot(x - 1400, y - 1050)
    grey = np.where(radius < 900, 150, 5).astype(np.float32)
    mask = content_mask(grey, None)
    margin = 0.015 * 2101
    assert mask.shape == grey.shape
    assert mask[radius < 900 - margin - 6].all()
    assert not mask[radius > 900 - margin + 6].any()


def test_what_lies_before_a_black_background_is_beyond_the_content() -> None:
    grey = np.full((480, 640), 5.0, np.float32)
    grey[120:360, 160:480] = 180.0
    content, beyond = content_masks(grey, None)
    assert not (content & beyond).any()
    assert content[240, 320]
    assert beyond[122, 320]
    assert beyond[60, 320]
    assert not beyond[:6].any()
    inner, outer = find_edges_apart(Picture(grey, content, beyond))
    assert len(inner) == 0
    assert len(outer) == pytest.approx(2 * (240 + 320), rel=0.02)
    circle = Boundary((320.0, 240.0), 400.0, 1.0, 1.0)
    assert not content_masks(grey, circle)[1][240, 525]


def test_dark_bars_that_run_out_of_the_frame_are_scene() -> None:
    grey = np.full((480, 640), 180.0, np.float32)
    for left in range(60, 600, 90):
        grey[:, left : left + 45] = 40.0
    mask = content_mask(grey, None)
    assert mask[10:-10, 10:-10].all()


@pytest.mark.parametrize("blur", [0.8, 2.0, 3.0])
def test_small_soft_squares_leave_nothing_even_and_are_seen(blur: float) -> None:
    model = DivisionModel(-8e-6, (163.0, 158.0), (320, 320))
    pose = Pose((160.0, 160.0), 17.0, tilt=10.0, rotation=12.0, focal=250.0)
    scene = BoardScene(model, Pattern(cols=22, rows=22), pose, camera=Camera(blur=blur, noise=2.0))
    found = calibrate(render_board(scene)).model
    assert found.lam == pytest.approx(model.lam, rel=5e-3)


@pytest.mark.parametrize(("blur", "vignetting"), [(0.6, 0.0), (0.6, 0.5), (0.9, 0.5)])
def test_small_sharp_squares_leave_a_little_even_and_are_seen(
    blur: float, vignetting: float
) -> None:
    model = DivisionModel(-1e-5, (156.0, 158.0), (320, 320))
    pose = Pose((156.0, 158.0), 16.0, tilt=10.0, rotation=12.0, focal=500.0)
    camera = Camera(blur=blur, vignetting=vignetting, noise=2.0)
    scene = BoardScene(model, Pattern(cols=32, rows=32), pose, camera=camera)
    result = calibrate(render_board(scene))
    assert result.model.lam == pytest.approx(model.lam, rel=2e-3)
    assert result.quality.verdict == "good"


def test_a_small_picture_of_a_sharp_board_is_seen(sample_data: Path) -> None:
    whole = read_image(sample_data / "board-2.png")
    small = cv2.resize(whole, (180, 135), interpolation=cv2.INTER_AREA)
    result = calibrate(small)
    assert result.quality.verdict == "good"
    scale = whole.shape[0] / small.shape[0]
    assert result.model.lam == pytest.approx(scale**2 * calibrate(whole).model.lam, rel=0.02)


@pytest.mark.parametrize("blur", [0.0, 1.0, 2.0])
def test_noise_that_was_smoothed_is_noise(blur: float) -> None:
    noise = np.random.default_rng(0).normal(100, 8, (400, 500)).astype(np.float32)
    grey = cv2.GaussianBlur(noise, (0, 0), blur) if blur else noise
    everywhere = np.ones(grey.shape, bool)
    assert len(find_edges(Picture(grey, everywhere))) < 50


@pytest.mark.parametrize("enlarging", [cv2.INTER_NEAREST, cv2.INTER_LINEAR, cv2.INTER_CUBIC])
@pytest.mark.parametrize("times", [2, 3])
def test_noise_that_was_enlarged_is_noise(times: int, enlarging: int) -> None:
    noise = np.random.default_rng(1).integers(0, 256, (480 // times, 640 // times), np.uint8)
    grey = cv2.resize(noise, (640, 480), interpolation=enlarging).astype(np.float32)
    assert len(find_edges(Picture(grey, np.ones(grey.shape, bool)))) < 50


def test_a_region_of_interest_is_the_limit() -> None:
    grey = np.random.default_rng(0).uniform(40, 200, (480, 640)).astype(np.float32)
    mask = content_mask(grey, None, roi=(100, 50, 200, 150))
    y, x = np.nonzero(mask)
    assert (x.min(), x.max(), y.min(), y.max()) == (100, 299, 50, 199)
