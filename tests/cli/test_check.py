"""``endocal check``: 0 where nothing moved, 1 with the number that did."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from endocal.files import load
from endocal.jobs import check as job


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory, sample_data: Path) -> Path:
    from endocal.files import save
    from endocal.jobs.calibrate import calibrate_files

    folder = tmp_path_factory.mktemp("recorded")
    shutil.copy(sample_data / "board-2.png", folder)
    save(calibrate_files([folder / "board-2.png"]), folder / "cal.toml")
    return folder


@pytest.fixture
def moved(recorded: Path, tmp_path: Path) -> Path:
    """The same calibration with a lambda that is half a standard deviation off."""
    calibration = load(recorded / "cal.toml")
    lam, sigma = calibration.model.lam, calibration.uncertainty.lam
    text = (recorded / "cal.toml").read_text()
    file = tmp_path / "moved.toml"
    file.write_text(
        text.replace(f"lambda = {lam!r}".replace("e-0", "e-"), f"lambda = {lam + sigma / 2!r}")
    )
    assert file.read_text() != text
    return file


def test_it_passes_in_a_pipeline(endocal: Callable[..., Any], recorded: Path) -> None:
    done = endocal("check", recorded / "cal.toml")
    assert (done.code, done.err) == (0, "")
    assert [line.split()[0] for line in done.out.splitlines()] == ["lambda", "center", "center"]


def test_a_number_that_moved_is_named_and_exits_1(
    endocal: Callable[..., Any], moved: Path, recorded: Path
) -> None:
    done = endocal("check", moved, "--images", recorded, "--json")
    assert done.code == 1
    (line,) = done.err.splitlines()
    assert "moved.toml: lambda moved by" in line
    assert "center" not in line
    report = json.loads(done.out)
    assert report["passed"] is False
    assert [n["passed"] for n in report["numbers"]] == [False, True, True]
    assert endocal("check", moved, "--images", recorded, "--tolerance", "0.6").code == 0


def test_a_verdict_that_changed_is_told(
    endocal: Callable[..., Any], recorded: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    calibration = load(recorded / "cal.toml")
    monkeypatch.setattr(job, "calibrate_files", lambda paths, spec: calibration)
    file = tmp_path / "cal.toml"
    text = (recorded / "cal.toml").read_text()
    file.write_text(text.replace('verdict = "good"', 'verdict = "doubtful"'))
    done = endocal("check", file, "--images", recorded)
    assert done.code == 0
    assert "the verdict was doubtful and is good now" in done.err


def test_a_missing_picture_fails_in_one_line(
    endocal: Callable[..., Any], recorded: Path, tmp_path: Path
) -> None:
    file = Path(shutil.copy(recorded / "cal.toml", tmp_path))
    assert "its picture board-2.png is not beside" in endocal("check", file).fails()


def test_a_tolerance_below_zero_is_wrong_usage(endocal: Callable[..., Any]) -> None:
    assert "--tolerance -1" in endocal("check", "cal.toml", "--tolerance", "-1").fails(2)
