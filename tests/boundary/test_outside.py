"""How dark the outside is taken to be, and what counts as dark all around a circle."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from endocal.boundary.detect import find_boundary
from endocal.boundary.fit import Circle
from endocal.boundary.frame import frame_of
from endocal.boundary.outside import Dark, blocks_of, darkest_corner, ends_at

SIZE = (540, 720)
CIRCLE = Circle(350.0, 270.0, 200.0)
Image = NDArray[np.uint8]


def noisy_disc(black: float, noise: float, radius: float = CIRCLE.radius, seed: int = 0) -> Image:
    y, x = np.mgrid[: SIZE[0], : SIZE[1]]
    levels = np.where(np.hypot(x - CIRCLE.x, y - CIRCLE.y) < radius, 250.0, black)
    levels = levels + np.random.default_rng(seed).normal(0, noise, SIZE)
    return np.clip(np.rint(levels), 0, 255).astype(np.uint8)


def ends(image: Image, dark: Dark | None = None, circle: Circle = CIRCLE) -> bool:
    frame = frame_of(image, 1.0)
    return ends_at(circle, blocks_of(frame), dark or darkest_corner(frame), 0.12, 0.005)


@pytest.mark.parametrize("noise", [1.0, 4.0, 8.0])
@pytest.mark.parametrize("deep", [False, True])
def test_the_corner_tells_level_and_noise(noise: float, deep: bool) -> None:
    image = noisy_disc(30, noise)
    dark = darkest_corner(frame_of(image.astype(np.uint16) << 4 if deep else image, 1.0))
    assert dark.level == pytest.approx(30, abs=0.5 + noise / 5)
    assert dark.noise == pytest.approx(noise, rel=0.4, abs=1)
    assert dark.level + dark.contrast == dark.threshold


def test_marks_in_three_corners_leave_the_fourth() -> None:
    image = noisy_disc(10, 2)
    image[:60, :200] = 180
    image[:60, -200:] = 90
    image[-60:, :200] = 240
    assert darkest_corner(frame_of(image, 1.0)).level == pytest.approx(10, abs=1)


@pytest.mark.parametrize("noise", [0.5, 3.0, 8.0])
@pytest.mark.parametrize("black", [0.0, 25.0])
def test_a_noisy_black_ends(black: float, noise: float) -> None:
    assert all(ends(noisy_disc(black, noise, seed=seed)) for seed in range(10))


def test_a_circle_within_the_content_is_not_dark_outside() -> None:
    assert not ends(noisy_disc(10, 2), circle=CIRCLE._replace(radius=150.0))


def test_clocks_and_names_are_no_scene_but_a_bright_side_is() -> None:
    marked = noisy_disc(10, 2)
    marked[20:40, 20:160] = 200
    assert ends(marked)
    scene = noisy_disc(10, 2)
    scene[:, 600:] = 40
    assert not ends(scene)


def test_a_ground_that_falls_off_slowly_is_not_flat() -> None:
    image = noisy_disc(0, 0.3)
    ramp = np.linspace(0, 30, SIZE[1])
    assert not ends(np.maximum(image, ramp).astype(np.uint8))


def test_glare_is_borne_near_the_circle_alone() -> None:
    circle = CIRCLE._replace(radius=262.0)
    y, x = np.mgrid[: SIZE[0], : SIZE[1]]
    away = np.hypot(x - circle.x, y - circle.y) / circle.radius
    image = noisy_disc(10, 1, radius=circle.radius)
    near, far = image.copy(), image.copy()
    near[(away > 1) & (away < 1.12)] = 30
    far[away > 1] = 30
    far[-60:, -60:] = 10
    dark = darkest_corner(frame_of(image, 1.0))
    assert not ends(near, circle=circle)
    assert ends(near, dark.raised(40.0), circle)
    assert not ends(far, dark.raised(40.0), circle)


@pytest.mark.parametrize("share", [0.8, 0.95])
def test_a_ring_on_black_is_no_picture_but_a_dark_cavity_is(share: float) -> None:
    ring, cavity = noisy_disc(5, 1), noisy_disc(5, 1)
    y, x = np.mgrid[: SIZE[0], : SIZE[1]]
    away = np.hypot(x - CIRCLE.x, y - CIRCLE.y) / CIRCLE.radius
    ring[away < share] = 5
    cavity[away < 0.6] = 5
    assert not ends(ring)
    assert ends(cavity)
    assert find_boundary(ring) is None
    assert find_boundary(cavity) is not None
