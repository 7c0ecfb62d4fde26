"""``correct --report``: the output, and a page of how it went."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("matplotlib")

Runner = Callable[..., Any]


def text_of(page: Path) -> str:
    text = re.sub(r"<(style|svg).*?</\1>", " ", page.read_text(), flags=re.DOTALL)
    return " ".join(re.sub(r"<[^>]+>", " ", text).split())


def test_the_page_of_a_zooming_clip(endocal: Runner, sample_data: Path, tmp_path: Path) -> None:
    page, table = tmp_path / "run.html", sample_data / "zoom.truth.toml"
    clip, out = sample_data / "clip.mp4", tmp_path / "out.mp4"
    done = endocal("correct", clip, "-o", out, "-c", table, "--report", page, "--codec", "mpeg4")
    assert done.code == 0, done.err
    assert sorted(p.name for p in tmp_path.iterdir()) == ["out.mp4", "run.html"]
    text = text_of(page)
    assert text.startswith("Correction: clip.mp4")
    assert "125 of 640x480 px" in text
    assert "mpeg4" in text
    assert "is rescaled to 640x480" in text
    # The clip zooms from 384 to 691 px (clip.truth.csv).
    low, high = map(int, re.search(r"circle (\d+) to (\d+) px wide", text).groups())  # type: ignore[union-attr]
    assert (low, high) == (pytest.approx(384, abs=2), pytest.approx(691, abs=7))
    assert page.read_text().count("<svg") == 3
    assert "The shaded band is the zoom that was calibrated" in text
    assert "var(--tint)" in page.read_text()
    # With a log of one's own, the log stays.
    log = tmp_path / "log.csv"
    done = endocal(
        *("correct", clip, "-o", out, "-c", table, "--report", page, "--codec", "mpeg4"),
        *("--overwrite", "--zoom-log", log),
    )
    assert done.code == 0
    assert len(log.read_text().splitlines()) == 126


def test_a_fixed_lens_has_a_page_without_zoom(
    endocal: Runner, sample_data: Path, tmp_path: Path
) -> None:
    truth = sample_data / "board-2.truth.toml"
    done = endocal(
        *("correct", sample_data / "clip.mp4", "-o", tmp_path / "out.mp4", "-c", truth),
        *("--codec", "mpeg4", "--report", tmp_path / "run.html"),
    )
    assert done.code == 0, done.err
    assert "125 of 640x480 px" in text_of(tmp_path / "run.html")
    assert "<svg" not in (tmp_path / "run.html").read_text()


def test_what_the_page_must_not_be(endocal: Runner, sample_data: Path, tmp_path: Path) -> None:
    clip, table = sample_data / "clip.mp4", sample_data / "zoom.truth.toml"
    out = tmp_path / "out.mp4"
    endocal("correct", clip, "-o", out, "-c", table, "--report", out).fails(2)
    endocal("correct", clip, "-o", "-", "-c", table, "--report", "-").fails(2)
    endocal("correct", clip, "-o", out, "-c", "-", "--report", tmp_path / "a.html").fails(2)
    board, truth = sample_data / "board-2.png", sample_data / "board-2.truth.toml"
    options = ("-o", tmp_path / "a.png", "-c", truth, "--report", tmp_path / "a.html")
    assert "is for videos" in endocal("correct", board, *options).fails(2)
    (tmp_path / "run.html").write_text("kept")
    options = ("-o", out, "-c", table, "--report", tmp_path / "run.html")
    assert "exists already" in endocal("correct", clip, *options).fails()
    assert [p.name for p in tmp_path.iterdir()] == ["run.html"]
    assert (tmp_path / "run.html").read_text() == "kept"
