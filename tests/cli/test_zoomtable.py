"""``endocal zoomtable`` from calibrations and pictures, and what it refuses."""

from __future__ import annotations

import hashlib
import json
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import pytest

from endocal.benchmarks.rim_frames import random_rim_frame
from endocal.boundary.detect import boundary_of
from endocal.calibration.result import Calibration, Quality
from endocal.files import load, save
from endocal.model import DivisionModel
from endocal.zoom.table import ZoomTable

SIZE = (720, 540)
STRENGTH = -1.3

Endocal = Callable[..., Any]


def setting(
    folder: Path,
    diameter: float,
    *,
    strength: float = STRENGTH,
    size: tuple[int, int] = SIZE,
    rim: bool = True,
    verdict: str = "good",
) -> Path:
    """A calibration at one zoom setting, in a file."""
    middle = ((size[0] - 1) / 2, (size[1] - 1) / 2)
    model = DivisionModel(strength / diameter**2, middle, size)
    boundary = boundary_of(middle, diameter, size) if rim else None
    path = folder / f"d{diameter:g}.toml"
    save(Calibration(model, boundary=boundary, quality=Quality(verdict)), path)
    return path


def test_calibrations_become_a_table(endocal: Endocal, tmp_path: Path) -> None:
    items = [setting(tmp_path, d) for d in (500.0, 400.0, 620.0)]
    out = tmp_path / "zoom.toml"
    result = endocal("zoomtable", *items, "-o", out)
    assert result.code == 0, result.err
    table = load(out)
    assert isinstance(table, ZoomTable)
    assert [s.diameter for s in table.settings] == [400, 500, 620]
    assert table.law.lambda_diameter2 == pytest.approx(STRENGTH, rel=1e-4)
    for s in table.settings:
        assert s.circle == (359.5, 269.5)
        assert s.area == pytest.approx(boundary_of((359.5, 269.5), s.diameter, SIZE).area, rel=1e-3)
        assert s.source is not None
        file = tmp_path / s.source.file
        assert s.source.sha256 == hashlib.sha256(file.read_bytes()).hexdigest()
    assert "law" in result.err
    # In whatever order they are named, the same bytes.
    again = tmp_path / "again.toml"
    endocal("zoomtable", *reversed(items), "-o", again)
    assert again.read_bytes() == out.read_bytes()


def test_json_tells_the_law_and_the_departures(endocal: Endocal, tmp_path: Path) -> None:
    items = [
        setting(tmp_path, d, strength=k)
        for d, k in ((400.0, -1.3), (500.0, -1.31), (560.0, -1.29), (640.0, -1.5))
    ]
    result = endocal("zoomtable", *items, "-o", tmp_path / "zoom.toml", "--json")
    data = json.loads(result.out)
    assert data["law"]["lambda_diameter2"] == pytest.approx(-1.305, rel=1e-3)
    assert data["law"]["departures"][3] == pytest.approx(1.5 / 1.305 - 1, rel=1e-2)
    assert "d640.toml" in data["notes"][0]
    assert "stands out" in result.err
    written = tomllib.loads((tmp_path / "zoom.toml").read_text())
    assert written["setting"] == data["setting"]


def test_a_doubtful_calibration_is_noted(endocal: Endocal, tmp_path: Path) -> None:
    items = [setting(tmp_path, 400.0, verdict="doubtful"), setting(tmp_path, 500.0)]
    result = endocal("zoomtable", *items, "-o", tmp_path / "zoom.toml")
    assert result.code == 0
    assert "d400.toml is doubtful" in result.err


def test_pictures_are_calibrated(endocal: Endocal, sample_data: Path, tmp_path: Path) -> None:
    truth = tomllib.loads((sample_data / "zoom.truth.toml").read_text())
    boards = [sample_data / "board-1.png", sample_data / "board-3.png"]
    out = tmp_path / "zoom.toml"
    result = endocal("zoomtable", *boards, "-o", out)
    assert result.code == 0, result.err
    table = load(out)
    assert isinstance(table, ZoomTable)
    true = [truth["setting"][i] for i in (0, 2)]
    for s, t in zip(table.settings, true, strict=True):
        assert s.lam == pytest.approx(t["lambda"], rel=0.005)
        assert s.center == pytest.approx(t["center"], abs=0.5)
        assert s.diameter == pytest.approx(t["diameter"], abs=1)


def refused(endocal: Endocal, tmp_path: Path, *items: Path) -> str:
    out = tmp_path / "zoom.toml"
    message = endocal("zoomtable", *items, "-o", out)
    lines = [line for line in message.err.splitlines() if ": reading " not in line]
    assert message.code == 1
    assert len(lines) == 1
    assert not message.out
    assert not out.exists()
    return str(lines[0])


def test_one_setting_is_no_table(endocal: Endocal, tmp_path: Path) -> None:
    assert "2 settings" in refused(endocal, tmp_path, setting(tmp_path, 400.0))


def test_the_same_diameter_twice_is_refused(endocal: Endocal, tmp_path: Path) -> None:
    item = setting(tmp_path, 400.0)
    assert "same diameter" in refused(endocal, tmp_path, item, item)


def test_frames_of_two_sizes_are_refused(endocal: Endocal, tmp_path: Path) -> None:
    items = [setting(tmp_path, 400.0), setting(tmp_path, 500.0, size=(1440, 1080))]
    message = refused(endocal, tmp_path, *items)
    assert "720x540" in message
    assert "1440x1080" in message


def test_settings_that_break_the_law_are_refused(endocal: Endocal, tmp_path: Path) -> None:
    items = [setting(tmp_path, d) for d in (400.0, 500.0)]
    items.append(setting(tmp_path, 600.0, strength=-1.9))
    assert "600 px (d600.toml)" in refused(endocal, tmp_path, *items)


def test_a_setting_without_a_rim_is_refused(endocal: Endocal, tmp_path: Path) -> None:
    items = [setting(tmp_path, 400.0), setting(tmp_path, 600.0, rim=False)]
    assert "d600.toml: no visible circle" in refused(endocal, tmp_path, *items)


def test_what_is_no_calibration_is_refused(endocal: Endocal, tmp_path: Path) -> None:
    good = [setting(tmp_path, d) for d in (400.0, 500.0)]
    table = tmp_path / "table.toml"
    assert endocal("zoomtable", *good, "-o", table).code == 0
    assert "is a zoom table" in refused(endocal, tmp_path, good[0], table)
    assert "missing.png" in refused(endocal, tmp_path, good[0], tmp_path / "missing.png")
    odd = tmp_path / "odd.toml"
    odd.write_text("schema = 1")
    assert "odd.toml" in refused(endocal, tmp_path, good[0], odd)


def test_an_output_that_exists_is_left_alone(endocal: Endocal, tmp_path: Path) -> None:
    items = [setting(tmp_path, d) for d in (400.0, 500.0)]
    out = tmp_path / "zoom.toml"
    out.write_text("mine")
    assert endocal("zoomtable", *items, "-o", out).code == 1
    assert out.read_text() == "mine"
    assert endocal("zoomtable", *items, "-o", out, "--overwrite").code == 0


def test_an_image_without_a_pattern_is_refused(endocal: Endocal, tmp_path: Path) -> None:
    image = tmp_path / "tissue.png"
    cv2.imwrite(str(image), random_rim_frame(1, "plain", SIZE).image)
    assert "tissue.png" in refused(endocal, tmp_path, image, setting(tmp_path, 400.0))


def test_two_things_on_stdout_are_wrong_usage(endocal: Endocal, tmp_path: Path) -> None:
    items = [setting(tmp_path, d) for d in (400.0, 500.0)]
    endocal("zoomtable", *items, "-o", "-", "--json").fails(2)
    piped = endocal("zoomtable", *items, "-o", "-")
    assert tomllib.loads(piped.out)["setting"][1]["diameter"] == 500
