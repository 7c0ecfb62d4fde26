"""``endocal compare``: the methods side by side, as a table, CSV and JSON."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from endocal.calibration.methods.registry import METHODS
from endocal.files import write_image
from endocal.jobs.compare import ComparisonSpec
from endocal.synth.board import render_board, true_lines

from ..calibration.scenes import board

SCENE = board(size=(320, 240), center=(162.0, 118.0), square=21.0, lam=-1e-5)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A board, its true lines, parallel bars, and nothing."""
    folder = tmp_path_factory.mktemp("compare")
    write_image(folder / "board.png", render_board(SCENE))
    lines = [line[:: max(1, len(line) // 30)] for line in true_lines(SCENE)]
    text = "\n\n".join("\n".join(f"{x} {y}" for x, y in line) for line in lines)
    (folder / "lines.txt").write_text(text)
    bars = board(size=(320, 240), center=(162.0, 118.0), square=21.0, lam=-1e-5, kind="lines")
    write_image(folder / "bars.png", render_board(bars))
    return folder


def test_methods_as_json(endocal: Callable[..., Any], folder: Path) -> None:
    lines = ("--lines", folder / "lines.txt")
    some = ("--samples", "6", "--method", "hewg,ht1d,htrdc,wang,corners,refined")
    done = endocal("compare", folder / "board.png", *some, *lines, "--json")
    assert done.code == 0, done.err
    report = json.loads(done.out)
    rows = {row["method"]: row for row in report["rows"]}
    assert list(rows) == some[3].split(",")
    before = report["images"][0]["straightness"]
    assert before > 1
    for name in ("hewg", "wang", "corners", "refined"):
        assert rows[name]["straightness"] < 0.4 * before, name
        assert rows[name]["rmse"] > 0
        assert rows[name]["seconds"] > 0
        assert rows[name]["refused"] is None
    # Given true lines, Wang's method finds the true lens.
    assert rows["wang"]["lambda"] == pytest.approx(-1e-5, rel=1e-4)
    assert rows["refined"]["lambda"] == pytest.approx(-1e-5, rel=0.01)


def test_all_are_compared_by_default() -> None:
    assert ComparisonSpec(("board.png",)).methods == (*METHODS, "refined")


def test_csv(endocal: Callable[..., Any], folder: Path) -> None:
    done = endocal(
        "compare", folder / "board.png", "--method", "wang,corners", "--board", "11x8", "--csv"
    )
    assert done.code == 0, done.err
    rows = list(csv.DictReader(io.StringIO(done.out)))
    assert [row["method"] for row in rows] == ["wang", "corners"]
    assert all(float(row["straightness"]) < 1 for row in rows)
    assert float(rows[1]["lambda"]) == pytest.approx(-1e-5, rel=0.1)


def test_the_table_says_who_refused_and_why(endocal: Callable[..., Any], folder: Path) -> None:
    done = endocal("compare", folder / "bars.png", "--method", "corners,refined")
    assert done.code == 0, done.err
    assert "corners: no chessboard found" in done.out
    assert "refused" in done.out
    for word in ("lambda", "centre", "RMSE", "straightness", "seconds", "refined"):
        assert word in done.out


def test_refined_all_agree(endocal: Callable[..., Any], folder: Path) -> None:
    done = endocal(
        "compare", folder / "board.png", "--method", "wang,corners", "--refine", "--json"
    )
    a, b = json.loads(done.out)["rows"]
    # The refinement forgets where it started.
    assert a["lambda"] == pytest.approx(b["lambda"], rel=1e-3)


def test_nothing_to_calibrate_from(endocal: Callable[..., Any], folder: Path) -> None:
    done = endocal("compare", folder / "bars.png", "--method", "corners")
    assert "no method" in done.fails(1)


def test_a_board_to_measure_on_that_is_not_there(endocal: Callable[..., Any], folder: Path) -> None:
    measured = ("compare", "--method", "wang", "--board")
    few = endocal(*measured, "5x4", folder / "board.png").fails(1)
    assert "board.png: the chessboard has" in few
    assert "more than --board 5x4 says" in few
    none = endocal(*measured, "11x8", folder / "bars.png").fails(1)
    assert "bars.png: no chessboard found" in none


def test_wrong_usage(endocal: Callable[..., Any], folder: Path) -> None:
    start = ("compare", folder / "board.png")
    words = endocal(*start, "--method", "magic").fails(2)
    assert "--method magic: one of hewg" in words
    assert "refined" in words
    assert "give one" in endocal(*start, "--csv", "--json").fails(2)
    lines = ("--lines", folder / "lines.txt")
    assert "give one" in endocal(*start, folder / "board.png", *lines).fails(2)
    assert "no.png" in endocal("compare", folder / "no.png").fails(1)
