"""``endocal show`` prints what the file holds."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from endocal.boundary.circle import Boundary
from endocal.calibration.result import (
    Calibration,
    Quality,
    Source,
    SourceImage,
    Uncertainty,
)
from endocal.files import dumps, save
from endocal.model import DivisionModel
from endocal.zoom.table import Setting, ZoomTable

CALIBRATION = Calibration(
    DivisionModel(-2.83e-6, (388.6, 275.7), (768, 576), lam2=1e-14),
    Uncertainty(1.2e-9, (0.11, 0.09), 2e-16),
    Boundary((383.0, 287.5), 712.0, 331000.0, 0.83),
    Quality("doubtful", ("few lines",), 26, 8120, 2.31, 0.13, 6.234, 0.12),
    Source("hewg", False, (SourceImage("cal.png", "0f" * 32),), "0.1.0"),
)
TABLE = ZoomTable(
    (Setting(-2.9644e-5, (360.0, 270.0), 210.0), Setting(-1.2742e-5, (361.25, 270.0), 312.0)),
    (720, 540),
)


@pytest.mark.parametrize("obj", [CALIBRATION, TABLE], ids=["calibration", "table"])
def test_json_is_the_file(
    tmp_path: Path, endocal: Callable[..., Any], obj: Calibration | ZoomTable
) -> None:
    path = tmp_path / "it.toml"
    save(obj, path)
    result = endocal("show", path, "--json")
    assert result.code == 0
    assert json.loads(result.out) == tomllib.loads(path.read_text())
    assert endocal("show", "-", "--json", stdin=path.read_bytes()).out == result.out


def test_a_calibration_in_words(endocal: Callable[..., Any]) -> None:
    out = endocal("show", "-", stdin=dumps(CALIBRATION).encode()).out
    for words in (
        "768x576 px",
        "-2.83e-06 ± 1.2e-09 px^-2",
        "1e-14 ± 2e-16 px^-4",
        "388.60, 275.70 ± 0.11, 0.09 px",
        "barrel: content ",
        "712.0 px wide, 83% of its rim in the frame",
        "doubtful: few lines",
        "2.31 -> 0.13 px over 8120 edge points on 26 lines but 12% that do not follow them",
        "endocal 0.1.0, method hewg, not refined",
        "cal.png",
    ):
        assert words in out


def test_the_effect_is_the_models(endocal: Callable[..., Any]) -> None:
    out = endocal("show", "-", stdin=dumps(CALIBRATION).encode()).out
    words = next(line for line in out.splitlines() if line.startswith("effect")).split()
    before, after = float(words[3]), float(words[10])
    moved = CALIBRATION.model.undistort([388.6 + before, 275.7])[0] - 388.6
    # Both are printed in whole pixels, and the rim is magnified some five times there.
    assert after == pytest.approx(moved, abs=4)


def test_a_table_in_words(endocal: Callable[..., Any]) -> None:
    out = endocal("show", "-", stdin=dumps(TABLE).encode()).out
    assert "720x540 px" in out
    assert "lambda * diameter^2 = -1.274, spread 2.63%" in out
    assert (
        "setting 1     diameter 210.0 px: lambda -2.9644e-05 px^-2, centre 360.00, 270.00 px" in out
    )
    assert "setting 2     diameter 312.0 px" in out


def test_what_cannot_be_read_is_exit_1(tmp_path: Path, endocal: Callable[..., Any]) -> None:
    assert "no such file" in endocal("show", tmp_path / "none.toml").fails()
    (tmp_path / "bad.toml").write_text("schema = 3")
    assert (
        endocal("show", tmp_path / "bad.toml").fails().startswith(f"endocal: {tmp_path}/bad.toml: ")
    )
    assert "<stdin>: is empty" in endocal("show", "-").fails()


def test_a_lens_that_folds_inside_the_frame_says_how_far_it_holds(
    tmp_path: Path, endocal: Callable[..., Any]
) -> None:
    calibration = Calibration(DivisionModel(-1e-5, (360.0, 270.0), (720, 540)), usable_radius=300.0)
    save(calibration, tmp_path / "cal.toml")
    out = endocal("show", tmp_path / "cal.toml").out
    # 300 / (1 - 1e-5 * 300^2) = 3000; the frame's corner lies beyond the fold, at 316 px.
    assert "content 300 px from the centre moves to 3000 px" in out
    assert "up to 300 px from the centre" in out


def test_a_centre_that_was_given_has_no_uncertainty(endocal: Callable[..., Any]) -> None:
    given = replace(CALIBRATION, uncertainty=Uncertainty(1.2e-9, (0.0, 0.0)))
    (centre,) = (
        line
        for line in endocal("show", "-", stdin=dumps(given).encode()).out.splitlines()
        if line.startswith("centre")
    )
    assert "as given" in centre
    assert "±" not in centre
