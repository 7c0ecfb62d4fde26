"""Bars of digital black about a picture whose own black is brighter."""

from __future__ import annotations

import numpy as np
import pytest

from endocal.boundary.bars import picture_between_bars
from endocal.boundary.detect import find_boundary
from endocal.boundary.frame import frame_of
from endocal.synth.camera import ContentCircle

SIZE = (640, 480)
CENTER = (322.0, 237.0)


def picture(diameter: float = 360.0, black: float = 4.0, seed: int = 0) -> np.ndarray:
    """Tissue within a circle, on a camera's noisy black: uint8 (h, w)."""
    circle = ContentCircle(CENTER, diameter, 2.0)
    noise = np.random.default_rng(seed).normal(0, 1.5, SIZE[::-1])
    light = black + 120 * circle.transmission(SIZE) + noise
    return np.clip(np.rint(light), 0, 255).astype(np.uint8)


def barred(luma: np.ndarray, rows: slice, columns: slice, level: int = 0) -> np.ndarray:
    framed = np.full_like(luma, level)
    framed[rows, columns] = luma[rows, columns]
    return framed


@pytest.mark.parametrize("black", [2.0, 4.0, 12.0])
@pytest.mark.parametrize(
    ("rows", "columns"),
    [
        (slice(31, 449), slice(0, 640)),
        (slice(31, 480), slice(0, 640)),
        (slice(0, 480), slice(83, 557)),
        (slice(20, 460), slice(51, 600)),
    ],
)
def test_the_circle_is_found_between_them(black: float, rows: slice, columns: slice) -> None:
    luma = picture(black=black)
    plain = find_boundary(luma)
    framed = barred(luma, rows, columns)
    assert picture_between_bars(frame_of(framed, 1.0)) == (rows, columns)
    found = find_boundary(framed)
    assert plain is not None
    assert found is not None
    assert found.diameter == pytest.approx(plain.diameter, abs=0.1)
    assert found.center == pytest.approx(plain.center, abs=0.1)
    assert found.visible == 1.0
    # From frame to frame it is looked for where it was.
    again = find_boundary(framed, guess=found)
    assert again is not None
    assert again.diameter == pytest.approx(plain.diameter, abs=0.1)


def test_bars_that_cut_the_circle_bound_it() -> None:
    framed = barred(picture(460.0), slice(60, 420), slice(0, 640))
    found = find_boundary(framed)
    assert found is not None
    assert found.diameter == pytest.approx(460, abs=0.5)
    assert 0.5 < found.visible < 0.7
    assert found.area == pytest.approx(np.count_nonzero(framed > 60), rel=0.01)


def test_sixteen_bits_and_pixels_that_are_not_square_are_no_other_matter() -> None:
    framed = barred(picture(), slice(31, 449), slice(0, 640))
    shallow = find_boundary(framed, 1.1)
    deep = find_boundary(framed.astype(np.uint16) * 256, 1.1)
    assert (deep is None) == (shallow is None)
    found = find_boundary(framed.astype(np.uint16) * 256)
    assert found is not None
    assert found.diameter == pytest.approx(360, abs=0.5)


def test_a_black_outside_is_no_bar() -> None:
    clean = picture()
    clean[clean < 12] = 0
    assert picture_between_bars(frame_of(clean, 1.0)) is None
    # Nor beside a bar, which then is the same black.
    clipped = picture(black=-1.0)
    assert (
        picture_between_bars(frame_of(barred(clipped, slice(40, 440), slice(0, 640)), 1.0)) is None
    )


@pytest.mark.parametrize("luma", [np.zeros((480, 640)), np.full((480, 640), 200), np.zeros((3, 3))])
def test_an_even_frame_holds_no_picture(luma: np.ndarray) -> None:
    frame = frame_of(luma.astype(np.uint8), 1.0)
    assert picture_between_bars(frame) is None


def test_a_small_picture_in_a_black_frame_is_left_to_the_search() -> None:
    framed = barred(picture(), slice(150, 300), slice(200, 420))
    assert picture_between_bars(frame_of(framed, 1.0)) is None


def test_a_scene_without_a_circle_between_bars_has_none() -> None:
    y, x = np.mgrid[: SIZE[1], : SIZE[0]]
    scene = (90 + 60 * np.sin(x / 37 + y / 61) + 20 * np.cos(x * y / 9000)).clip(3, 255)
    framed = barred(scene.astype(np.uint8), slice(40, 440), slice(0, 640))
    assert picture_between_bars(frame_of(framed, 1.0)) == (slice(40, 440), slice(0, 640))
    assert find_boundary(framed) is None
