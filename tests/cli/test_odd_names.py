"""Names of files that hold a line break, which the system allows: each message stays on its line."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from endocal.synth.board import render_board

from ..calibration.scenes import board

Runner = Callable[..., Any]

ODD = "two\nlines"
SIZE = (320, 240)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a picture whose name is odd."""
    folder = tmp_path_factory.mktemp("odd")
    scene = board(size=SIZE, center=(162.0, 118.0), square=21.0, lam=-1e-5)
    cv2.imwrite(str(folder / "board.png"), render_board(scene))
    (folder / "board.png").rename(folder / f"{ODD}.png")
    return folder


@pytest.fixture
def folder(made: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(made, tmp_path / "copy"))


def lines_of(text: str) -> list[str]:
    """The lines of stderr, each of which begins as ours do."""
    lines = text.splitlines()
    assert all(line.startswith("endocal: ") for line in lines), text
    return lines


def test_calibrate_check_and_evaluate(endocal: Runner, folder: Path) -> None:
    picture, file = folder / f"{ODD}.png", folder / f"{ODD}.toml"
    done = endocal("calibrate", picture, "-o", file)
    assert done.code == 0, done.err
    assert lines_of(done.err)[-1] == f"endocal: {str(file)!r}: good"
    assert endocal("check", file).code == 0
    done = endocal("evaluate", "-c", file, picture)
    assert repr(str(picture)) in done.out
    assert len(done.out.splitlines()) == 2
    file.write_text(file.read_text().replace("lambda = -", "lambda = -1", 1))
    failed = endocal("check", file)
    assert failed.code == 1
    assert lines_of(failed.err)[0].startswith(f"endocal: {str(file)!r}: lambda moved")


def test_evaluate_tells_its_notes_on_a_line(endocal: Runner, folder: Path) -> None:
    picture = folder / f"{ODD}.png"
    (folder / "cal.toml").write_text(
        'schema = "endocal.calibration/1"\n[model]\ntype = "division"\n'
        "lambda = -2.5e-6\ncenter = [324.5, 236.5]\nsize = [640, 480]\n"
    )
    done = endocal("evaluate", "-c", folder / "cal.toml", picture)
    assert done.code == 0, done.err
    (line,) = lines_of(done.err)
    assert repr(str(picture)) in line


def test_a_picture_left_out_and_a_page(endocal: Runner, folder: Path) -> None:
    pytest.importorskip("matplotlib")
    noise = np.random.default_rng(1).normal(0, 1, SIZE[::-1])
    clouds = cv2.normalize(cv2.GaussianBlur(noise, (0, 0), 8), None, 0, 255, cv2.NORM_MINMAX)
    cv2.imwrite(str(folder / "clouds.png"), clouds.astype(np.uint8))
    left_out = (folder / "clouds.png").rename(folder / f"clouds {ODD}.png")
    page = folder / f"{ODD}.html"
    pictures = (folder / f"{ODD}.png", left_out)
    done = endocal("calibrate", *pictures, "-o", folder / "cal.toml", "--report", page)
    assert done.code == 0, done.err
    lines = lines_of(done.err)
    assert lines[0].startswith(f"endocal: note: {str(left_out)!r} left out: ")
    assert lines[-1] == f"endocal: {str(page)!r}: its page"


@pytest.mark.parametrize("spoilt", [b"", b"\x89PNG\r\n\x1a\n"])
def test_a_picture_that_is_refused(endocal: Runner, folder: Path, spoilt: bytes) -> None:
    picture = folder / f"{ODD}.png"
    picture.write_bytes(spoilt)
    line = endocal("calibrate", picture, "-o", folder / "cal.toml").fails(1)
    assert line.startswith(f"endocal: {str(picture)!r}: is ")


def test_a_picture_that_fails(endocal: Runner, folder: Path) -> None:
    picture = folder / f"{ODD}.png"
    image = np.full(SIZE[::-1], 200.0)
    for place in range(30, 300, 60):
        cv2.circle(image, (place, 120), 20, 40, -1, cv2.LINE_AA)
    data = cv2.imencode(".png", image.astype(np.uint8))[1].tobytes()
    picture.write_bytes(data)
    line = endocal("calibrate", picture, "-o", folder / "cal.toml").fails(1)
    assert line.startswith(f"endocal: {str(picture)!r}: ")
