"""``endocal evaluate``: both measures, on lines from a file, from a board, and found."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from endocal.calibration.result import Calibration
from endocal.files import save, write_image
from endocal.model import DivisionModel
from endocal.synth.board import render_board, true_lines
from endocal.zoom.table import Setting, ZoomTable

from ..calibration.scenes import board

SCENE = board(size=(480, 360), center=(243.0, 178.0), square=31.0, lam=-4e-6)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A board, its true lines, its true lens, and a lens that does nothing."""
    folder = tmp_path_factory.mktemp("evaluate")
    write_image(folder / "board.png", render_board(SCENE))
    lines = [line[:: max(1, len(line) // 40)] for line in true_lines(SCENE)]
    text = "\n\n".join("\n".join(f"{x} {y}" for x, y in line) for line in lines)
    (folder / "lines.txt").write_text(text)
    save(Calibration(SCENE.model), folder / "true.toml")
    save(Calibration(DivisionModel(0.0, (240.0, 180.0), (480, 360))), folder / "none.toml")
    return folder


def measured(endocal: Callable[..., Any], *args: Any) -> dict[str, Any]:
    done = endocal("evaluate", *args, "--json")
    assert done.code == 0, done.err
    return json.loads(done.out)


def test_chosen_lines(endocal: Callable[..., Any], folder: Path) -> None:
    lines = ("--lines", folder / "lines.txt", folder / "board.png")
    found = measured(endocal, "-c", folder / "true.toml", *lines)
    # Exact points, and the exact lens.
    assert found["all"]["rmse"] < 1e-6
    assert found["all"]["straightness"] < 1e-4
    assert found["all"]["rmse_before"] > 1.5
    assert found["images"][0]["image"].endswith("board.png")
    nothing = measured(endocal, "-c", folder / "none.toml", *lines)["all"]
    assert nothing["rmse"] == pytest.approx(nothing["rmse_before"])


def test_the_corners_of_a_board(endocal: Callable[..., Any], folder: Path) -> None:
    found = measured(endocal, "-c", folder / "true.toml", "--board", "11x8", folder / "board.png")
    # Corners are found to about a tenth of a px at noise of two grey levels.
    assert found["all"]["straightness"] < 0.2 < 1 < found["all"]["straightness_before"]
    assert 17 <= found["all"]["lines"] <= 19
    few = endocal("evaluate", "-c", folder / "true.toml", "--board", "5x4", folder / "board.png")
    assert "inner corners, more than --board 5x4 says" in few.fails(1)
    many = endocal("evaluate", "-c", folder / "true.toml", "--board", "50x40", folder / "board.png")
    assert "less than half of what --board 50x40 says" in many.fails(1)


def test_lines_that_it_finds_itself(endocal: Callable[..., Any], folder: Path) -> None:
    done = endocal("evaluate", "-c", folder / "true.toml", folder / "board.png")
    assert done.code == 0, done.err
    row = done.out.splitlines()[1].split()
    before, after = float(row[-3]), float(row[-1])
    assert after < 0.1 < 1 < before
    assert done.out.splitlines()[0].split() == [
        "lines", "points", "RMSE,", "px", "straightness,", "px",
    ]  # fmt: skip
    assert len(done.out.splitlines()) == 2


def test_several_pictures_are_pooled(endocal: Callable[..., Any], folder: Path) -> None:
    picture = folder / "board.png"
    report = measured(endocal, "-c", folder / "true.toml", "--board", "11x8", picture, picture)
    one, both = report["images"][0], report["all"]
    assert both["points"] == 2 * one["points"]
    assert both["rmse"] == pytest.approx(one["rmse"])


def test_a_zoom_table_is_looked_up_by_the_circle(
    endocal: Callable[..., Any], folder: Path, sample_data: Path
) -> None:
    picture = sample_data / "board-2.png"
    found = measured(endocal, "-c", sample_data / "zoom.truth.toml", picture)
    # The interpolated truth, on lines found to some hundredths of a px.
    assert found["all"]["straightness"] < 0.2 < 3 < found["all"]["straightness_before"]


def test_a_lens_that_folds(endocal: Callable[..., Any], folder: Path, tmp_path: Path) -> None:
    strong = Calibration(DivisionModel(-3e-5, (243.0, 178.0), (480, 360)), usable_radius=150.0)
    save(strong, tmp_path / "strong.toml")
    lines = ("--lines", folder / "lines.txt", folder / "board.png")
    assert measured(endocal, "-c", tmp_path / "strong.toml", *lines)["all"]["rmse"] is None
    done = endocal("evaluate", "-c", tmp_path / "strong.toml", *lines)
    assert "folded" in done.out


def test_wrong_usage(endocal: Callable[..., Any], folder: Path, tmp_path: Path) -> None:
    start = ("evaluate", "-c", folder / "true.toml", folder / "board.png")
    lines = ("--lines", folder / "lines.txt")
    assert "give one" in endocal(*start, *lines, "--board", "11x8").fails(2)
    assert "give one" in endocal(*start, folder / "board.png", *lines).fails(2)
    assert "--board '11': write COLUMNSxROWS" in endocal(*start, "--board", "11").fails(2)
    (tmp_path / "off.txt").write_text("1 1\n2 2\n900 3\n")
    off = endocal(*start, "--lines", tmp_path / "off.txt").fails(2)
    assert "line 1 leaves the 480x360 px picture at 900,3" in off
    for text, words in (
        ("5 5\n5 5\n5 5\n", "line 1 has fewer than 3 different points"),
        ("1 1\n20 2\n30 3\n\n5 5\n9 9\n5 5\n", "line 2 has fewer than 3 different points"),
        ("5 5\n5.1 5\n5.2 5\n", "line 1 has no length: 1 px is the least"),
    ):
        (tmp_path / "none.txt").write_text(text)
        assert words in endocal(*start, "--lines", tmp_path / "none.txt").fails(2)
    assert "no.txt: no such file" in endocal(*start, "--lines", tmp_path / "no.txt").fails(1)
    missing = endocal("evaluate", "-c", folder / "true.toml", tmp_path / "no.png")
    assert "no.png" in missing.fails(1)


def test_another_shape_is_refused(
    endocal: Callable[..., Any], folder: Path, tmp_path: Path
) -> None:
    save(Calibration(DivisionModel(-1e-6, (240.0, 240.0), (480, 480))), tmp_path / "square.toml")
    done = endocal("evaluate", "-c", tmp_path / "square.toml", folder / "board.png")
    assert "another shape" in done.fails(1)


def test_the_lens_of_another_size_is_rescaled(
    endocal: Callable[..., Any], folder: Path, tmp_path: Path
) -> None:
    twice = SCENE.model.rescale((960, 720))
    save(Calibration(twice), tmp_path / "twice.toml")
    lines = ("--lines", folder / "lines.txt", folder / "board.png")
    done = endocal("evaluate", "-c", tmp_path / "twice.toml", *lines, "--json")
    assert "rescaled to 480x360" in done.err
    assert json.loads(done.out)["all"]["rmse"] < 1e-5


def test_a_zoom_table_without_a_circle_says_so(
    endocal: Callable[..., Any], folder: Path, tmp_path: Path
) -> None:
    table = ZoomTable(
        (Setting(-4e-6, (243.0, 178.0), 300.0), Setting(-2e-6, (243.0, 178.0), 424.0)), (480, 360)
    )
    save(table, tmp_path / "zoom.toml")
    done = endocal("evaluate", "-c", tmp_path / "zoom.toml", folder / "board.png")
    assert done.code in (0, 1)
    assert "Traceback" not in done.err
