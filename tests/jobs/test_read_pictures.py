"""Pictures that show the same are no evidence of their own, and are named."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from endocal.errors import InputError
from endocal.files import read_image, write_image
from endocal.jobs.calibrate import report_files
from endocal.jobs.read_pictures import ReadPicture, copies_among
from endocal.synth.board import render_board

from ..calibration.scenes import board


@pytest.fixture
def first(tmp_path: Path) -> Path:
    path = tmp_path / "first.png"
    write_image(path, render_board(board()))
    return path


def test_a_copy_is_left_out_and_named(first: Path) -> None:
    copy = first.with_name("copy.jpg")
    write_image(copy, read_image(first))
    report = report_files([first, copy])
    ((path, reason),) = report.left_out
    assert path == str(copy)
    assert reason == f"it shows the same as {first}"
    alone = report_files([first])
    assert report.calibration.uncertainty == alone.calibration.uncertainty
    assert report.calibration.source == alone.calibration.source


@pytest.mark.parametrize("seed", range(3))
def test_a_second_frame_of_a_still_camera_is_a_copy_and_another_view_is_none(
    first: Path, seed: int
) -> None:
    image = read_image(first).astype(float)
    noise = np.random.default_rng(seed).normal(0, 4, image.shape)
    second, moved = (first.with_name(name) for name in ("second.png", "moved.png"))
    write_image(second, np.clip(image + noise, 0, 255).astype(np.uint8))
    write_image(moved, render_board(board(rotation=13.0, seed=seed)))
    pictures = [ReadPicture.of(path) for path in (first, second, moved)]
    assert [(a.path, b.path) for a, b in copies_among(pictures)] == [(second, first)]


def test_faint_boards_in_one_circle_are_views_of_their_own(first: Path) -> None:
    # What all views of an endoscope share, the bright circle, must not hide how they differ.
    y, x = np.mgrid[:480, :640]
    inside = np.hypot(x - 320, y - 240) < 220
    for name, rotation in (("a.png", 5.0), ("b.png", 25.0)):
        faint = 120 + 0.05 * (render_board(board(rotation=rotation)).astype(float) - 120)
        shape = inside.reshape(inside.shape + (1,) * (faint.ndim - 2))
        write_image(first.with_name(name), np.where(shape, faint, 5).astype(np.uint8))
    a, b = (ReadPicture.of(first.with_name(name)) for name in ("a.png", "b.png"))
    assert not a.shows_what(b)


def test_small_boards_in_an_even_circle_are_views_of_their_own(first: Path) -> None:
    y, x = np.mgrid[:480, :640]
    disc = np.where(np.hypot(x - 320, y - 240) < 220, 150, 5).astype(np.uint8)
    small = cv2.resize(cv2.imread(str(first), cv2.IMREAD_GRAYSCALE), (128, 96))
    faint = (150 + 0.3 * (small.astype(float) - 128)).astype(np.uint8)
    views = []
    for column in (200, 320):
        view = disc.copy()
        view[180:276, column : column + 128] = faint
        views.append(ReadPicture("view.png", b"", view))
    assert not views[0].shows_what(views[1])


@pytest.mark.parametrize("kind", ["black", "grey"])
def test_blank_pictures_show_nothing_in_common(kind: str) -> None:
    level = 0 if kind == "black" else 128
    a, b = (ReadPicture("blank.png", b"", np.full((480, 640), level, np.uint8)) for _ in range(2))
    assert not a.shows_what(b)


def test_the_same_picture_twice_is_refused_in_whatever_kind_of_file(first: Path) -> None:
    again = first.with_name("again.bmp")
    cv2.imwrite(str(again), cv2.imread(str(first)))
    with pytest.raises(InputError, match=r"again\.bmp: the same picture as .*first\.png"):
        list(copies_among([ReadPicture.of(path) for path in (first, again)]))
