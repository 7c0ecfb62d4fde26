"""``endocal report`` and ``calibrate --report``: pages that say what is there, and what is not."""

from __future__ import annotations

import base64
import os
import re
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from endocal.files import load, save
from endocal.model import DivisionModel
from endocal.zoom.table import Setting, SettingSource, ZoomTable

pytest.importorskip("matplotlib")

Runner = Callable[..., Any]
# A page is to be mailed and kept by the thousand.
MOST_BYTES = 3_000_000


@pytest.fixture(scope="module")
def calibrated(tmp_path_factory: pytest.TempPathFactory, sample_data: Path) -> Path:
    """A folder with board.png, cal.toml and cal.html."""
    from endocal.cli.app import run

    folder = tmp_path_factory.mktemp("calibrated")
    shutil.copy(sample_data / "board-2.png", folder / "board.png")
    options = ("-o", str(folder / "cal.toml"), "--report", str(folder / "cal.html"))
    assert run(["calibrate", str(folder / "board.png"), *options]) == 0
    return folder


def text_of(page: Path) -> str:
    """What a page says, without its figures."""
    text = re.sub(r"<(style|svg).*?</\1>", " ", page.read_text(), flags=re.DOTALL)
    return " ".join(re.sub(r"<[^>]+>", " ", text).split())


def pictures_of(page: Path) -> list[np.ndarray]:
    found = re.findall(r'<img src="data:image/jpeg;base64,([^"]+)"', page.read_text())
    data = [np.frombuffer(base64.b64decode(f), np.uint8) for f in found]
    return [cv2.imdecode(d, cv2.IMREAD_COLOR) for d in data]


def test_the_page_says_what_was_found(calibrated: Path) -> None:
    page, calibration = calibrated / "cal.html", load(calibrated / "cal.toml")
    text = text_of(page)
    quality = calibration.quality
    assert "Good: this calibration can be trusted" in text
    assert f"{quality.lines}, with {quality.points} points" in text
    x, y = calibration.model.center
    assert f"{x:.2f}, {y:.2f}" in text
    assert f"{1e6 * calibration.model.lam:.5f}·10⁻⁶".replace("-", "−") in text
    assert calibration.source.images[0].sha256 in text
    for heading in ("Before and after", "What is left", "How sure it is", "The search", "votes"):
        assert heading in text
    assert page.stat().st_size < MOST_BYTES


def test_every_figure_says_what_it_shows(calibrated: Path) -> None:
    page = (calibrated / "cal.html").read_text()
    assert page.count("<svg") == 10
    assert page.count("<svg") == len(
        re.findall(r'<svg [^>]*role="img" aria-label="[^"]{20,}"', page)
    )
    assert page.count("<img") == len(re.findall(r'<img [^>]*alt="[^"]{10,}"', page)) == 2


def test_lines_are_drawn_where_they_were_found(calibrated: Path, sample_data: Path) -> None:
    before, after = pictures_of(calibrated / "cal.html")
    original = cv2.imread(str(sample_data / "board-2.png"))
    scale = before.shape[1] / original.shape[1]
    blue = before[..., 0].astype(int) - before[..., 2] > 80
    ys, xs = np.nonzero(blue)
    # 23 lines of some 300 px, 2 px wide or wider when shown.
    assert len(xs) > 23 * 300 * scale
    # Nearly all of it lies on edges of the original: black and white within 4 px.
    grey = cv2.cvtColor(original, cv2.COLOR_BGR2GRAY)
    kernel = np.ones((9, 9), np.uint8)
    contrast = cv2.dilate(grey, kernel).astype(int) - cv2.erode(grey, kernel)
    at = contrast[(ys / scale).astype(int), (xs / scale).astype(int)]
    assert np.mean(at > 40) > 0.97
    # No line is bent by more than a good calibration's may be.
    red = before[..., 2].astype(int) - before[..., 0] > 120
    assert red.mean() < 1e-3
    assert after.shape == before.shape


def test_the_corrected_picture_is_the_models(calibrated: Path, sample_data: Path) -> None:
    _, after = pictures_of(calibrated / "cal.html")
    model = load(calibrated / "cal.toml").model
    original = cv2.imread(str(sample_data / "board-2.png"))
    scale = after.shape[1] / original.shape[1]
    x, y = np.meshgrid(np.arange(100, 620, 4.0), np.arange(80, 460, 4.0))
    at = model.distort(np.stack([x, y], axis=-1)).astype(np.float32)
    straight = cv2.remap(original, at[..., 0], at[..., 1], cv2.INTER_LINEAR).astype(float)
    shown = ((np.stack([x, y], axis=-1) + 0.5) * scale - 0.5).astype(np.float32)
    found = cv2.remap(after, shown[..., 0], shown[..., 1], cv2.INTER_LINEAR).astype(float)
    # Two resamplings and JPEG: a few grey levels, more at edges.
    assert np.median(np.abs(found - straight)) < 3
    assert np.corrcoef(found.ravel(), straight.ravel())[0, 1] > 0.99


def test_it_is_made_again_from_the_file_alike_each_time(
    endocal: Runner, calibrated: Path, tmp_path: Path
) -> None:
    page, again, elsewhere = tmp_path / "a.html", tmp_path / "b.html", tmp_path / "cal.toml"
    done = endocal("report", calibrated / "cal.toml", "-o", page)
    assert done.code == 0
    assert done.err == f"endocal: {page}: page of {calibrated / 'cal.toml'}\n"
    shutil.copy(calibrated / "cal.toml", elsewhere)
    assert endocal("report", elsewhere, "--images", calibrated, "-o", again).code == 0
    assert page.read_bytes() == again.read_bytes()
    # And it says the same as the page of the calibration itself.
    assert text_of(page) == text_of(calibrated / "cal.html")


def test_the_page_goes_beside_the_file_and_over_nothing(
    endocal: Runner, calibrated: Path, tmp_path: Path
) -> None:
    shutil.copy(calibrated / "cal.toml", tmp_path)
    assert endocal("report", tmp_path / "cal.toml").code == 0
    assert (tmp_path / "cal.html").exists()
    assert "exists already" in endocal("report", tmp_path / "cal.toml").fails()
    assert endocal("report", tmp_path / "cal.toml", "--overwrite").code == 0
    endocal("report", "-").fails(2)


def test_a_picture_that_is_gone_is_told(endocal: Runner, calibrated: Path, tmp_path: Path) -> None:
    shutil.copy(calibrated / "cal.toml", tmp_path)
    done = endocal("report", tmp_path / "cal.toml")
    words = "its picture board.png is not beside"
    assert words in done.err
    text = text_of(tmp_path / "cal.html")
    assert words in text
    assert "Good: this calibration can be trusted" in text
    assert not pictures_of(tmp_path / "cal.html")


def test_a_number_that_moved_is_told(endocal: Runner, calibrated: Path, tmp_path: Path) -> None:
    shutil.copy(calibrated / "board.png", tmp_path)
    text = (calibrated / "cal.toml").read_text()
    (tmp_path / "cal.toml").write_text(re.sub(r"center = \[\d+", "center = [361", text, count=1))
    done = endocal("report", tmp_path / "cal.toml")
    assert done.code == 0
    assert "center x moved by" in done.err
    page = text_of(tmp_path / "cal.html")
    assert "center x moved by" in page
    assert "can be trusted" not in page
    assert "Doubtful" in page


def test_numbers_by_hand_are_enough(endocal: Runner, tmp_path: Path) -> None:
    (tmp_path / "cal.toml").write_text(
        'schema = "endocal.calibration/1"\n[model]\ntype = "division"\nlambda = -2.83e-6\n'
        "center = [388.6, 275.7]\nsize = [768, 576]\n"
    )
    assert endocal("report", tmp_path / "cal.toml").code == 0
    text = text_of(tmp_path / "cal.html")
    assert "No verdict" in text
    assert "388.60, 275.70" in text


def test_a_failed_calibration_has_a_page_and_no_file(
    endocal: Runner, sample_data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from endocal.calibration import quality

    # As if the lines had to be straighter than any picture's.
    monkeypatch.setattr(quality, "FAILED_ROUGH", 1e-4)
    page = tmp_path / "<b>.html"
    result = endocal(
        *("calibrate", sample_data / "board-1.png", "-o", tmp_path / "cal.toml", "--report", page)
    )
    assert result.code == 1
    assert not (tmp_path / "cal.toml").exists()
    assert "Failed: do not correct with this calibration" in text_of(page)
    assert "px from straight: the model does not fit them" in text_of(page)


def test_a_zoom_table_shows_its_law(endocal: Runner, tmp_path: Path) -> None:
    diameters = (420.0, 520.0, 640.0, 780.0)
    settings = [
        Setting(-1.3 / d**2, (365 - d / 200, 262 + d / 100), d, None, 0.0, SettingSource("<x>.png"))
        for d in diameters
    ]
    save(ZoomTable(tuple(settings), (720, 540)), tmp_path / "zoom.toml")
    assert endocal("report", tmp_path / "zoom.toml").code == 0
    text = text_of(tmp_path / "zoom.html")
    assert "Good: the settings agree" in text
    assert "−1.3000" in text
    assert "+0.00 % &lt;x&gt;.png" in text

    settings[2] = Setting(-1.3 * 1.2 / 640**2, settings[2].center, 640.0)
    save(ZoomTable(tuple(settings), (720, 540)), tmp_path / "zoom.toml", overwrite=True)
    assert endocal("report", tmp_path / "zoom.toml", "--overwrite").code == 0
    text = text_of(tmp_path / "zoom.html")
    assert "Doubtful: one setting stands out" in text
    assert "640.0 px λ is +20.0 % off the law" in text


def test_a_table_comes_with_its_page(endocal: Runner, sample_data: Path, tmp_path: Path) -> None:
    settings = [sample_data / f"board-{i}.truth.toml" for i in (1, 2, 3)]
    page, table = tmp_path / "a.html", tmp_path / "zoom.toml"
    done = endocal("zoomtable", *settings, "-o", table, "--report", page)
    assert done.code == 0, done.err
    assert endocal("report", table, "-o", tmp_path / "b.html").code == 0
    assert text_of(page) == text_of(tmp_path / "b.html")
    again = ("-o", tmp_path / "c.toml", "--report")
    assert "is also an input" in endocal("zoomtable", *settings, *again, settings[0]).fails()
    endocal("zoomtable", *settings, *again, tmp_path / "c.toml").fails(2)
    assert not (tmp_path / "c.toml").exists()


def test_a_zoom_table_of_two_parameters(endocal: Runner, tmp_path: Path) -> None:
    settings = tuple(
        Setting(-1.0 / d**2, (360.0, 270.0), d, lam2=-0.2 / d**4) for d in (400.0, 600.0)
    )
    save(ZoomTable(settings, (720, 540)), tmp_path / "zoom.toml")
    assert endocal("report", tmp_path / "zoom.toml").code == 0
    assert "λ₂" in text_of(tmp_path / "zoom.html")


def test_a_log_shows_the_zoom_over_time(endocal: Runner, tmp_path: Path) -> None:
    rows = ["frame,time,diameter,source,lambda,center_x,center_y,uncertainty"]
    for i in range(5000):
        source, sigma = ("held", 0.04) if 2000 <= i < 2050 else ("rim", 0.001)
        d = 400 + i / 50
        rows.append(f"{i},{i / 25},{d},{source},{-1.3 / d**2},360,270,{sigma}")
    (tmp_path / "log.csv").write_text("\n".join(rows) + "\n")
    assert endocal("report", tmp_path / "log.csv").code == 0
    text = text_of(tmp_path / "log.html")
    assert "In 50 of 5000 frames the diameter is less sure than ± 3%, first at 80.00 s" in text
    assert "50 1.0% 2.0 s from 80.00 s" in text
    assert "1.25 ×" in text
    page = (tmp_path / "log.html").read_text()
    assert page.count("<svg") == 3
    assert "var(--orange)" in page
    assert len(page) < MOST_BYTES / 6


def test_a_log_of_diameters_alone(endocal: Runner, tmp_path: Path) -> None:
    lines = ['{"frame": 0, "diameter": 400}', "", '{"frame": 5, "diameter": 480}']
    (tmp_path / "log.jsonl").write_text("\n".join(lines))
    assert endocal("report", tmp_path / "log.jsonl").code == 0
    assert "1.20 ×" in text_of(tmp_path / "log.html")
    assert (tmp_path / "log.html").read_text().count("<svg") == 1
    (tmp_path / "bad.csv").write_text("frame,radius\n0,3\n")
    assert "line 2: needs a diameter" in endocal("report", tmp_path / "bad.csv").fails()


def test_without_matplotlib_it_says_what_to_install(
    endocal: Runner, sample_data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    words = "pip install 'endocal-toolchain[report]'"
    assert words in endocal("report", sample_data / "zoom.truth.toml", "-o", "-").fails()
    options = ("-o", tmp_path / "cal.toml", "--report", tmp_path / "cal.html")
    assert words in endocal("calibrate", sample_data / "board-1.png", *options).fails()
    assert not list(tmp_path.iterdir())


def test_the_page_is_no_other_file(endocal: Runner, sample_data: Path, tmp_path: Path) -> None:
    shutil.copy(sample_data / "board-1.png", tmp_path)
    board = tmp_path / "board-1.png"
    before = board.read_bytes()
    options = ("-o", tmp_path / "cal.toml", "--overwrite", "--report", board)
    assert "is also an input" in endocal("calibrate", board, *options).fails()
    options = ("-o", tmp_path / "a", "--report", tmp_path / "a")
    endocal("calibrate", board, *options).fails(2)
    endocal("calibrate", board, "-o", "-", "--report", "-").fails(2)
    assert board.read_bytes() == before


@pytest.mark.parametrize("way", ["itself", "link", "symlink"])
def test_a_page_never_replaces_a_picture_of_its_calibration(
    endocal: Runner, calibrated: Path, tmp_path: Path, way: str
) -> None:
    folder = tmp_path / "pictures"
    folder.mkdir()
    shutil.copy(calibrated / "board.png", folder)
    shutil.copy(calibrated / "cal.toml", tmp_path)
    board = page = folder / "board.png"
    if way == "link":
        (page := tmp_path / "page.html").hardlink_to(board)
    elif way == "symlink":
        (page := tmp_path / "page.html").symlink_to(board)
    text = (tmp_path / "cal.toml").read_text()
    # One that is gone does not make the other a file like any.
    gone = '{ file = "gone.png", sha256 = "00" }, '
    (tmp_path / "two.toml").write_text(text.replace("images = [", f"images = [{gone}"))
    assert gone in (tmp_path / "two.toml").read_text()
    before = board.read_bytes()
    for file in ("cal.toml", "two.toml"):
        options = ("--images", folder, "-o", page, "--overwrite")
        assert "is also an input" in endocal("report", tmp_path / file, *options).fails()
        assert board.read_bytes() == before


def test_a_page_has_no_other_files_name(endocal: Runner, sample_data: Path, tmp_path: Path) -> None:
    words = "a report is an HTML page: name it .html"
    board, table, clip = (sample_data / n for n in ("board-1.png", "zoom.truth.toml", "clip.mp4"))
    page = tmp_path / "k.pdf"
    assert words in endocal("report", table, "-o", page).fails(2)
    options = ("-o", tmp_path / "out", "--report", page)
    assert words in endocal("calibrate", board, *options).fails(2)
    assert words in endocal("zoomtable", table, table, *options).fails(2)
    options = ("-o", tmp_path / "out.mp4", "-c", table, "--report", page)
    assert words in endocal("correct", clip, *options).fails(2)
    options = ("--out", tmp_path / "out", "-c", table, "--report", ".pdf", "--dry-run")
    assert f"--report .pdf: {words}" in endocal("batch", clip, *options).fails(2)
    assert not list(tmp_path.iterdir())
    for name in ("k.HTM", "page"):
        assert endocal("report", table, "-o", tmp_path / name).code == 0


def test_the_model_of_pixels_that_are_not_square(endocal: Runner, tmp_path: Path) -> None:
    from endocal.report import pictures

    model = DivisionModel(-3e-6, (360.0, 288.0), (720, 576), pixel_aspect=16 / 15)
    image = np.zeros((576, 720), np.uint16)
    image[288, 500:] = 65535
    shown, scale = pictures.to_show(image, model.pixel_aspect)
    assert shown.shape == (round(576 * scale), round(720 * 16 / 15 * scale), 3)
    after = pictures.corrected(shown, model)
    # A ray from the centre stays on its row.
    rows = np.nonzero(after.max(axis=(1, 2)) > 60)[0]
    assert abs(rows.mean() - (288.5 * scale - 0.5)) < 1


def test_a_home_that_cannot_be_written_is_no_news(
    endocal_process: Runner, sample_data: Path, tmp_path: Path
) -> None:
    page, table = tmp_path / "zoom.html", sample_data / "zoom.truth.toml"
    env = {"HOME": os.devnull, "XDG_CONFIG_HOME": os.devnull, "XDG_CACHE_HOME": os.devnull}
    done = endocal_process("report", table, "-o", page, env={**env, "MPLCONFIGDIR": ""})
    assert (done.code, done.err) == (0, f"endocal: {page}: page of {table}\n")


@pytest.mark.parametrize("name", [".", ""])
def test_a_name_of_no_file_is_refused(endocal: Runner, name: str) -> None:
    done = endocal("report", name)
    assert done.code == 1
    assert "is no file to make a page of" in done.err
