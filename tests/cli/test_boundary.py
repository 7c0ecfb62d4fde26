"""``endocal boundary`` on pictures and videos, those without a circle and those that are none."""

from __future__ import annotations

import json
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from endocal.benchmarks.plain_frames import random_plain_frame
from endocal.benchmarks.rim_frames import random_rim_frame

FRAME = random_rim_frame(3, "instruments", (720, 540))

Endocal = Callable[..., Any]


@pytest.fixture
def picture(tmp_path: Path) -> Path:
    path = tmp_path / "scope.png"
    cv2.imwrite(str(path), FRAME.image)
    return path


def lines(text: str) -> list[dict[str, Any]]:
    return [json.loads(line) for line in text.splitlines()]


def test_a_picture_gives_one_line(endocal: Endocal, picture: Path) -> None:
    result = endocal("boundary", picture)
    assert result.code == 0, result.err
    (line,) = lines(result.out)
    assert (line["frame"], line["time"]) == (0, None)
    found = line["boundary"]
    assert found["diameter"] == pytest.approx(FRAME.diameter, abs=0.5)
    assert found["center"] == pytest.approx(FRAME.center, abs=0.5)
    assert found["visible"] == 1
    assert found["area"] == pytest.approx(np.pi / 4 * FRAME.diameter**2, rel=0.01)
    # A whole rim with little noise.
    assert 0 < found["uncertainty"]["diameter"] < 0.3
    assert 0 < found["uncertainty"]["center"] < 0.3
    assert "circle in 1 of 1" in result.err


def test_a_rim_that_is_cut_says_how_much_that_leaves_open(endocal: Endocal, tmp_path: Path) -> None:
    frame = random_rim_frame(0, "cut 3 sides", (720, 540))
    path = tmp_path / "cut.png"
    cv2.imwrite(str(path), frame.image)
    (line,) = lines(endocal("boundary", path).out)
    found = line["boundary"]
    sigma = found["uncertainty"]["diameter"]
    # What an ellipse of a third of a percent makes of an arc, and not noise alone.
    assert sigma > 0.002 * frame.diameter
    assert abs(found["diameter"] - frame.diameter) < 3 * sigma


def test_a_picture_comes_through_a_pipe(endocal: Endocal, picture: Path) -> None:
    piped = endocal("boundary", "-", "--quiet", stdin=picture.read_bytes())
    assert piped.code == 0
    assert piped.out == endocal("boundary", picture).out
    assert not piped.err


def test_without_a_circle_the_boundary_is_null(endocal: Endocal, tmp_path: Path) -> None:
    path = tmp_path / "plain.png"
    cv2.imwrite(str(path), random_plain_frame(0)[0])
    result = endocal("boundary", path)
    assert result.code == 0
    assert lines(result.out) == [{"frame": 0, "time": None, "boundary": None}]
    assert "circle in 0 of 1" in result.err


def test_the_pixel_aspect_is_honoured(endocal: Endocal, tmp_path: Path) -> None:
    frame = random_rim_frame(1, "pixel aspect", (720, 576))
    path = tmp_path / "pal.png"
    cv2.imwrite(str(path), frame.image)
    result = endocal("boundary", path, "--pixel-aspect", str(frame.pixel_aspect))
    assert lines(result.out)[0]["boundary"]["diameter"] == pytest.approx(frame.diameter, abs=0.5)
    # As if the pixels were square, it is an ellipse, and found at best as something else.
    square = lines(endocal("boundary", path).out)[0]["boundary"]
    assert square is None or abs(square["diameter"] - frame.diameter) > 2


def test_the_overlay_of_a_picture_shows_the_circle(
    endocal: Endocal, picture: Path, tmp_path: Path
) -> None:
    overlay = tmp_path / "overlay.png"
    assert endocal("boundary", picture, "--overlay", overlay).code == 0
    drawn = cv2.imread(str(overlay), cv2.IMREAD_GRAYSCALE)
    assert drawn is not None
    changed = np.argwhere(drawn != FRAME.image)
    far = np.hypot(changed[:, 1] - FRAME.center[0], changed[:, 0] - FRAME.center[1])
    assert len(changed) > 1000
    assert np.abs(far - FRAME.diameter / 2).max() < 4
    # Existing files are left alone, and the input always is.
    assert "exists" in endocal("boundary", picture, "--overlay", overlay).err
    refused = endocal("boundary", picture, "--overlay", picture, "--overwrite")
    assert refused.code == 1


def test_a_video_gives_a_line_per_frame_and_an_overlay(
    endocal: Endocal, sample_data: Path, tmp_path: Path
) -> None:
    overlay = tmp_path / "overlay.mp4"
    result = endocal("boundary", sample_data / "clip.mp4", "--overlay", overlay)
    assert result.code == 0, result.err
    found = lines(result.out)
    assert [line["frame"] for line in found] == list(range(len(found)))
    assert all(a["time"] < b["time"] for a, b in pairwise(found))
    truth = (sample_data / "clip.truth.csv").read_text().splitlines()
    column = truth[0].split(",").index("diameter")
    diameters = [float(row.split(",")[column]) for row in truth[1:]]
    assert len(diameters) == len(found)
    seen = [
        (line["boundary"]["diameter"], true)
        for line, true in zip(found, diameters, strict=True)
        if line["boundary"] is not None
    ]
    assert len(seen) > 0.9 * len(found)
    errors = [abs(a - b) for a, b in seen]
    # The clip's rim is soft and compressed.
    assert np.median(errors) < 1
    assert np.percentile(errors, 95) < 2
    again = endocal("boundary", overlay, "--quiet")
    assert len(lines(again.out)) == len(found)


def test_a_video_that_breaks_off_is_told(
    endocal: Endocal, sample_data: Path, tmp_path: Path
) -> None:
    whole, half = tmp_path / "whole.mkv", tmp_path / "half.mkv"
    assert endocal("boundary", sample_data / "clip.mp4", "--overlay", whole).code == 0
    data = whole.read_bytes()
    half.write_bytes(data[: len(data) // 2])
    result = endocal("boundary", half)
    assert result.code == 0
    assert 0 < len(lines(result.out)) < 125
    assert f"warning: {half}: the file breaks off before its end" in result.err


@pytest.mark.parametrize(
    ("content", "words"),
    [(None, "no such file"), (b"", ""), (b"not a video", ""), (b"\x89PNG\r\n\x1a\n", "")],
)
def test_what_is_no_picture_or_video_is_refused(
    endocal: Endocal, tmp_path: Path, content: bytes | None, words: str
) -> None:
    path = tmp_path / "input.mp4"
    if content is not None:
        path.write_bytes(content)
    message = endocal("boundary", path).fails()
    assert "input.mp4" in message
    assert words in message


def test_a_senseless_pixel_aspect_is_wrong_usage(endocal: Endocal, picture: Path) -> None:
    endocal("boundary", picture, "--pixel-aspect", "-1").fails(2)


def test_the_real_clip_keeps_its_circle(endocal: Endocal, real_data: Path) -> None:
    result = endocal("boundary", real_data / "endoscopy" / "laparoscopy_1280x720.mp4")
    found = [line["boundary"] for line in lines(result.out)]
    assert len(found) == 250
    assert all(found)
    diameters = [b["diameter"] for b in found]
    assert max(diameters) - min(diameters) <= 2
