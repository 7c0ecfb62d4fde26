"""The pages as a browser shows them: nothing missing, nothing refused, light, dark and on paper."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from endocal.batch.report import Line
from endocal.cli.app import run
from tests.batch.test_page import FACTS
from tests.batch.test_page import page as batch_page
from tests.browser import Browser

pytest.importorskip("matplotlib")


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory, sample_data: Path) -> list[Path]:
    """One page of each kind."""
    folder = tmp_path_factory.mktemp("pages")
    (folder / "log.csv").write_text(
        "frame,time,diameter,source,lambda,uncertainty\n"
        "0,0,400,rim,-8e-6,0.001\n1,0.04,410,held,-7.6e-6,0.002\n2,0.08,415,tracked,-7.4e-6,0.04\n"
    )
    names = ("cal", "zoom", "log")
    calibration, table, log = (folder / f"{name}.html" for name in names)
    board, truth = sample_data / "board-1.png", sample_data / "zoom.truth.toml"
    for words in (
        ("calibrate", board, "-o", folder / "cal.toml", "--report", calibration),
        ("report", truth, "-o", table),
        ("report", folder / "log.csv", "-o", log),
    ):
        assert run([str(word) for word in words]) == 0
    batch = folder / "batch.html"
    failure = Line("b/<i>.mp4", "/raw/b", "failed", "is no <video>", True)
    batch.write_text(batch_page(Line("a.mp4", "/raw/a.mp4", "done", None, True, FACTS), failure))
    return [calibration, table, log, batch]


def test_the_console_stays_silent(browser: Browser, pages: list[Path], tmp_path: Path) -> None:
    # It would speak: here is what a page must not have.
    policy = "<meta http-equiv=Content-Security-Policy content=\"default-src 'none'\">"
    bad = tmp_path / "bad.html"
    bad.write_text(f"<!DOCTYPE html>{policy}<title>bad</title><script>1</script>")
    assert browser.console(bad)
    for page in pages:
        assert browser.console(page) == []


def test_it_is_light_or_dark_as_the_reader_likes_and_prints(
    browser: Browser, pages: list[Path]
) -> None:
    page = pages[0]
    light, dark = browser.screenshot(page), browser.screenshot(page, dark=True)
    # The margins show the page's own ground, and text stands out from it.
    assert light[:, :20].min() > 240
    assert dark[:, :20].max() < 40
    assert light[:400].min() < 40
    assert dark[:400].max() > 215
    # The picture of the board is there, below the numbers, and differs from the ground in many places.
    assert np.mean(np.abs(light.astype(int) - light[0, 0]).max(axis=2) > 60) > 0.1
    assert browser.paper(page).startswith(b"%PDF")
