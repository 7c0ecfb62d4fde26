"""``endocal calibrate --method``: every method by name, and chosen lines from a file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from endocal.calibration.methods.registry import METHODS
from endocal.files import load, write_image
from endocal.synth.board import render_board, true_lines

from ..calibration.scenes import board


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A board as board.png, and its lines as lines.txt."""
    folder = tmp_path_factory.mktemp("methods")
    scene = board(size=(320, 240), center=(162.0, 118.0), square=21.0, lam=-1e-5)
    write_image(folder / "board.png", render_board(scene))
    lines = [line[:: max(1, len(line) // 40)] for line in true_lines(scene)]
    text = "\n\n".join("\n".join(f"{x:.3f} {y:.3f}" for x, y in line) for line in lines)
    (folder / "lines.txt").write_text(f"# chosen with care\n{text}\n")
    return folder


@pytest.mark.parametrize("method", METHODS)
def test_each_method_by_name(endocal: Callable[..., Any], folder: Path, method: str) -> None:
    out = folder / f"{method}.toml"
    done = endocal(
        "calibrate", folder / "board.png", "-o", out, "--method", method, "--no-refine",
        "--samples", "3", "--center", "162,118",
    )  # fmt: skip
    assert done.code == 0, done.err
    found = load(out)
    assert found.source.method == method
    assert not found.source.refined
    assert found.uncertainty is None
    assert found.quality.verdict == "doubtful"


def test_chosen_lines_are_used_and_kept(endocal: Callable[..., Any], folder: Path) -> None:
    out = folder / "chosen.toml"
    command = ("--method", "wang", "--no-refine", "--lines", folder / "lines.txt")
    done = endocal("calibrate", folder / "board.png", "-o", out, *command)
    assert done.code == 0, done.err
    found = load(out)
    # The lines are the truth, rounded to a thousandth of a px.
    assert found.model.lam == pytest.approx(-1e-5, rel=1e-3)
    np.testing.assert_allclose(found.model.center, (162, 118), atol=0.05)
    assert len(found.source.options["lines"]) >= 15
    # They go with the file, so that it can be made again without them.
    assert endocal("check", out).code == 0


def test_the_chosen_lines_are_not_written_over(endocal: Callable[..., Any], folder: Path) -> None:
    lines = folder / "lines.txt"
    before = lines.read_bytes()
    command = ("calibrate", folder / "board.png", "--method", "wang", "--lines", lines)
    assert "is also an input" in endocal(*command, "-o", lines, "--overwrite").fails()
    assert lines.read_bytes() == before


def test_refinement_follows_any_method(endocal: Callable[..., Any], folder: Path) -> None:
    out = folder / "refined.toml"
    done = endocal("calibrate", folder / "board.png", "-o", out, "--method", "corners")
    assert done.code == 0, done.err
    found = load(out)
    assert found.model.lam == pytest.approx(-1e-5, rel=0.01)
    assert found.quality.entropy is None


def test_wrong_usage(endocal: Callable[..., Any], folder: Path, tmp_path: Path) -> None:
    start = ("calibrate", folder / "board.png", "-o", tmp_path / "cal.toml")
    assert "--method magic: one of hewg, heplp" in endocal(*start, "--method", "magic").fails(2)
    lines = ("--lines", folder / "lines.txt")
    assert "goes with --method wang or htrdc" in endocal(*start, *lines).fails(2)
    two = endocal(*start, folder / "board.png", *lines, "--method", "wang")
    assert "--lines are those of one picture" in two.fails(2)
    missing = endocal(*start, "--method", "wang", "--lines", tmp_path / "no.txt")
    assert "no.txt: no such file" in missing.fails(1)
