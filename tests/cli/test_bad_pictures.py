"""Pictures that calibrate must refuse: one clear line, exit 1, no file."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from endocal.errors import InputError
from endocal.jobs.calibrate import calibrate_files

Runner = Callable[..., Any]

SIZE = (320, 240)


def refused(endocal: Runner, folder: Path, name: str, words: str) -> None:
    before = set(folder.rglob("*"))
    for output in (folder / "cal.toml", "-"):
        result = endocal("calibrate", folder / name, "-o", output)
        line = result.fails()
        assert words in line
        assert name in line
        assert set(folder.rglob("*")) == before


@pytest.fixture
def noise() -> np.ndarray:
    return np.random.default_rng(3).normal(0, 2, SIZE[::-1])


def save(folder: Path, image: np.ndarray) -> bytes:
    data = cv2.imencode(".png", np.clip(image, 0, 255).astype(np.uint8))[1].tobytes()
    (folder / "board.png").write_bytes(data)
    return data


def test_one_that_may_not_be_read_is_refused_as_one_that_is_missing(
    endocal: Runner, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    picture = tmp_path / "board.png"
    picture.touch(0o000)
    # Root may read anything, and finds it empty.
    monkeypatch.setattr(os, "access", lambda *args, **options: False)
    line = endocal("calibrate", picture, "-o", tmp_path / "cal.toml").fails(1)
    assert line.startswith(f"endocal: {picture}: ")
    assert "cannot be read: Permission denied" in line or "is empty" in line


def test_missing(endocal: Runner, tmp_path: Path) -> None:
    refused(endocal, tmp_path, "board.png", "no such file")


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "is empty: take another copy"),
        (b"a text" * 99, "is not a PNG, JPEG, TIFF or BMP picture: convert it to one"),
    ],
)
def test_no_picture(endocal: Runner, tmp_path: Path, data: bytes, words: str) -> None:
    (tmp_path / "board.png").write_bytes(data)
    refused(endocal, tmp_path, "board.png", words)


def test_truncated(endocal: Runner, tmp_path: Path, noise: np.ndarray) -> None:
    data = save(tmp_path, 128 + noise)
    (tmp_path / "board.png").write_bytes(data[: len(data) // 2])
    refused(endocal, tmp_path, "board.png", "is truncated")


def test_one_pixel(endocal: Runner, tmp_path: Path) -> None:
    save(tmp_path, np.zeros((1, 1)))
    refused(endocal, tmp_path, "board.png", "too small")


@pytest.mark.parametrize("level", [0, 128, 255])
def test_all_one_colour(endocal: Runner, tmp_path: Path, level: int) -> None:
    save(tmp_path, np.full(SIZE[::-1], level))
    refused(endocal, tmp_path, "board.png", "")


def test_nothing_but_noise(endocal: Runner, tmp_path: Path, noise: np.ndarray) -> None:
    save(tmp_path, 128 + 8 * noise)
    refused(endocal, tmp_path, "board.png", "")


def test_nothing_but_the_visible_circle(endocal: Runner, tmp_path: Path, noise: np.ndarray) -> None:
    y, x = np.mgrid[0 : SIZE[1], 0 : SIZE[0]]
    save(tmp_path, np.where(np.hypot(x - 160, y - 120) < 100, 150, 4) + noise)
    refused(endocal, tmp_path, "board.png", "")


def test_round_things(endocal: Runner, tmp_path: Path, noise: np.ndarray) -> None:
    image = np.full(SIZE[::-1], 200.0)
    for cx in range(20, 320, 40):
        for cy in range(20, 240, 40):
            cv2.circle(image, (cx, cy), 9, 40, -1, cv2.LINE_AA)
    save(tmp_path, image + noise)
    result = endocal("calibrate", tmp_path / "board.png", "-o", tmp_path / "cal.toml")
    # Rows of dots have a straight order, so that a small distortion may be found; never a wild one.
    if result.code == 0:
        lam = float((tmp_path / "cal.toml").read_text().split("lambda = ")[1].split()[0])
        assert abs(lam) * 200**2 < 0.02
    else:
        result.fails()


def test_an_output_that_exists_is_refused_before_the_work(
    endocal: Runner, tmp_path: Path, noise: np.ndarray
) -> None:
    save(tmp_path, 128 + noise)
    (tmp_path / "cal.toml").write_text("precious")
    line = endocal("calibrate", tmp_path / "board.png", "-o", tmp_path / "cal.toml").fails()
    assert "cal.toml: exists already" in line
    assert (tmp_path / "cal.toml").read_text() == "precious"


def test_an_output_directory_that_is_not_there(
    endocal: Runner, tmp_path: Path, noise: np.ndarray
) -> None:
    save(tmp_path, 128 + noise)
    result = endocal("calibrate", tmp_path / "board.png", "-o", tmp_path / "no" / "cal.toml")
    assert "does not exist" in result.fails()


def test_a_picture_given_twice(endocal: Runner, tmp_path: Path, noise: np.ndarray) -> None:
    save(tmp_path, 128 + noise)
    picture, copy = tmp_path / "board.png", tmp_path / "copy.png"
    copy.write_bytes(picture.read_bytes())
    for twice in (picture, copy):
        result = endocal("calibrate", picture, twice, "-o", tmp_path / "cal.toml")
        assert f"{twice.name}: the same picture as" in result.fails(1)
    with pytest.raises(InputError, match="the same picture as"):
        calibrate_files([picture, picture])


@pytest.mark.parametrize("kind", ["bmp", "tif"])
def test_a_picture_given_twice_in_other_files(
    endocal: Runner, tmp_path: Path, noise: np.ndarray, kind: str
) -> None:
    save(tmp_path, 128 + noise)
    again = tmp_path / f"again.{kind}"
    cv2.imwrite(str(again), cv2.imread(str(tmp_path / "board.png"), cv2.IMREAD_COLOR))
    result = endocal("calibrate", tmp_path / "board.png", again, "-o", tmp_path / "cal.toml")
    assert f"{again.name}: the same picture as" in result.fails(1)


@pytest.mark.parametrize(
    "options",
    [
        ["--method", "magic"],
        ["--center", "middle"],
        ["--center", "1,2,3"],
        ["--samples", "1"],
        ["--samples", "100000"],
        ["--pixel-aspect", "nan"],
        ["--pixel-aspect", "inf"],
        ["--pixel-aspect", "100000"],
        ["--sobel", "4"],
        ["--roi", "1,2,3"],
        ["--model", "brown"],
        ["--nonsense"],
    ],
)
def test_wrong_usage(endocal: Runner, tmp_path: Path, options: list[str]) -> None:
    y, x = np.mgrid[0 : SIZE[1], 0 : SIZE[0]]
    save(tmp_path, 60 + 140 * ((x // 25 + y // 25) % 2))
    result = endocal("calibrate", tmp_path / "board.png", "-o", tmp_path / "cal.toml", *options)
    result.fails(2)
    assert [p.name for p in tmp_path.iterdir()] == ["board.png"]
