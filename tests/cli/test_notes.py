"""Notes for the user on standard error."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from endocal.calibration.result import Calibration
from endocal.cli.options import note
from endocal.files import load
from endocal.synth.board import render_board

from ..calibration.scenes import board


def test_a_note_that_cannot_be_told_does_no_harm(monkeypatch: pytest.MonkeyPatch) -> None:
    if not Path("/dev/full").exists():
        pytest.skip("no /dev/full here")
    with open("/dev/full", "w", buffering=1) as full:
        monkeypatch.setattr("sys.stderr", full)
        note("done")
        with pytest.raises(OSError, match="No space left"):
            full.close()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
def test_a_file_that_was_written_is_told_before_json_that_cannot_be(tmp_path: Path) -> None:
    scene = board(size=(320, 240), center=(162.0, 118.0), square=21.0, lam=-1e-5)
    cv2.imwrite(str(tmp_path / "board.png"), render_board(scene))
    command = ["calibrate", "board.png", "-o", "cal.toml", "--report", "cal.html", "--json"]
    with open("/dev/full", "wb") as full:
        done = subprocess.run(
            [sys.executable, "-m", "endocal", *command],
            cwd=tmp_path,
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert done.returncode == 1
    *_, file, page, failure = done.stderr.splitlines()
    assert file == "endocal: cal.toml: good"
    assert page == "endocal: cal.html: its page"
    assert failure.startswith("endocal: standard output: ")
    assert isinstance(load(tmp_path / "cal.toml"), Calibration)


@pytest.mark.parametrize("pages", [1, 2])
def test_pages_that_are_not_looked_at_are_named(
    endocal: Callable[..., Any], tmp_path: Path, pages: int
) -> None:
    scene = board(size=(320, 240), center=(162.0, 118.0), square=21.0, lam=-1e-5)
    written = cv2.imwritemulti(str(tmp_path / "board.tif"), [render_board(scene)] * pages)
    assert written
    done = endocal("calibrate", tmp_path / "board.tif", "-o", tmp_path / "cal.toml")
    assert done.code == 0, done.err
    assert ("board.tif holds 2 pages: only the first is looked at" in done.err) == (pages > 1)


def test_a_second_parameter_is_told_with_its_uncertainty(
    endocal: Callable[..., Any], tmp_path: Path
) -> None:
    scene = board(lam=-1.2e-6, lam2=-6e-12)
    cv2.imwrite(str(tmp_path / "board.png"), render_board(scene))
    file = tmp_path / "cal.toml"
    done = endocal("calibrate", tmp_path / "board.png", "-o", file, "--model", "division2")
    assert done.code == 0, done.err
    found = load(file)
    assert isinstance(found, Calibration)
    assert found.uncertainty is not None
    assert found.uncertainty.lam2 is not None
    told = re.search(r"lambda2 (\S+) ± (\S+) px\^-4$", done.err, re.MULTILINE)
    assert told, done.err
    assert float(told[1]) == pytest.approx(found.model.lam2, rel=1e-4)
    assert float(told[2]) == pytest.approx(found.uncertainty.lam2, rel=0.05)
    assert re.search(r"^lambda2 +-\S+ ± \S+ px\^-4$", endocal("show", file).out, re.MULTILINE)


def test_a_picture_of_no_pattern_is_named(endocal: Callable[..., Any], tmp_path: Path) -> None:
    scene = board(size=(320, 240), center=(162.0, 118.0), square=21.0, lam=-1e-5)
    noise = np.random.default_rng(1).normal(0, 1, (240, 320))
    clouds = cv2.normalize(cv2.GaussianBlur(noise, (0, 0), 8), None, 0, 255, cv2.NORM_MINMAX)
    for name, picture in (("board.png", render_board(scene)), ("clouds.png", clouds)):
        assert cv2.imwrite(str(tmp_path / name), picture.astype(np.uint8))
    paths = (tmp_path / name for name in ("clouds.png", "board.png"))
    done = endocal("calibrate", *paths, "-o", tmp_path / "cal.toml")
    assert done.code == 0, done.err
    assert "clouds.png left out: no pattern of straight lines found in it" in done.err
    assert "clouds" not in (tmp_path / "cal.toml").read_text()
