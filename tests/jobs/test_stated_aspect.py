"""Pixel aspects that pictures' files state: taken where the lines bear them out, and told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from endocal import CalibrationSpec
from endocal.files import decode_image, encode_image
from endocal.jobs.calibrate import report_files
from endocal.synth.board import render_board

from ..calibration.scenes import board
from ..files.test_pixel_shape import phys, with_chunks

LAM = -6e-6
WIDE = 16 / 15


@pytest.fixture(scope="module")
def wide() -> bytes:
    """A board seen with pixels that are wider than high."""
    scene = board(LAM, (190.0, 146.0), (375, 300), pixel_aspect=WIDE, square=26.0)
    return encode_image(render_board(scene), ".png")


@pytest.fixture(scope="module")
def square() -> bytes:
    return encode_image(render_board(board(LAM, (203.0, 146.0), (400, 300), square=26.0)), ".png")


@pytest.mark.parametrize("numbers", [(16, 15), (15, 16)])
def test_it_is_taken_whichever_way_round_it_is_stated(
    tmp_path: Path, wide: bytes, numbers: tuple[int, int]
) -> None:
    (tmp_path / "pal.png").write_bytes(with_chunks(wide, phys(*numbers)))
    report = report_files([tmp_path / "pal.png"])
    model = report.calibration.model
    assert model.pixel_aspect == report.spec.pixel_aspect == pytest.approx(WIDE)
    assert model.lam == pytest.approx(LAM, rel=0.005)
    assert report.calibration.quality is not None
    assert report.calibration.quality.verdict == "good"
    (note,) = report.notes
    assert "taken as 1.0667 times as wide as high" in note


def test_a_wrong_one_is_not_taken(tmp_path: Path, square: bytes) -> None:
    (tmp_path / "shot.png").write_bytes(with_chunks(square, phys(853, 720)))
    report = report_files([tmp_path / "shot.png"])
    assert report.calibration.model.pixel_aspect == 1
    assert report.calibration.model.lam == pytest.approx(LAM, rel=0.005)
    (note,) = report.notes
    assert "shot.png says 853:720 of its pixels, which its lines do not bear out" in note


def test_what_is_given_has_the_say(tmp_path: Path, wide: bytes) -> None:
    (tmp_path / "pal.png").write_bytes(with_chunks(wide, phys(16, 15)))
    report = report_files([tmp_path / "pal.png"], CalibrationSpec(pixel_aspect=1.0))
    assert report.calibration.model.pixel_aspect == 1
    assert report.notes == ()


def test_bare_methods_ask_for_it(tmp_path: Path, wide: bytes) -> None:
    (tmp_path / "pal.png").write_bytes(with_chunks(wide, phys(16, 15)))
    spec = CalibrationSpec(refine=False, samples=4, max_rounds=2)
    report = report_files([tmp_path / "pal.png"], spec)
    assert report.calibration.model.pixel_aspect == 1
    (note,) = report.notes
    assert note.endswith("give --pixel-aspect")


def test_stills_of_video_whose_pixels_are_seldom_square_are_asked_about(tmp_path: Path) -> None:
    scene = board(-1.7e-6, (355.0, 290.0), (720, 576), square=50.0)
    (tmp_path / "still.png").write_bytes(encode_image(render_board(scene), ".png"))
    spec = CalibrationSpec(refine=False, samples=4, max_rounds=2)
    (note,) = report_files([tmp_path / "still.png"], spec).notes
    assert "1.0667 or 1.4222 times as wide as high" in note
    assert "--pixel-aspect" in note
    given = CalibrationSpec(refine=False, samples=4, max_rounds=2, pixel_aspect=1.0)
    assert report_files([tmp_path / "still.png"], given).notes == ()


def test_of_pictures_that_state_different_ones_the_first_is_tried(
    tmp_path: Path, wide: bytes
) -> None:
    image = decode_image(wide)
    other = with_chunks(encode_image(np.ascontiguousarray(image[::-1]), ".png"), phys(2, 1))
    (tmp_path / "a.png").write_bytes(with_chunks(wide, phys(16, 15)))
    (tmp_path / "b.png").write_bytes(other)
    report = report_files([tmp_path / "a.png", tmp_path / "b.png"])
    assert report.calibration.model.pixel_aspect == pytest.approx(WIDE)
    first, second = report.notes
    assert "a.png says 16:15 of its pixels: taken as 1.0667" in first
    assert (
        "b.png says 2:1 of its pixels, which its lines do not bear out: taken as 1.0667" in second
    )
