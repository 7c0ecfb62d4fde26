"""With a zoom table the circle is found in every format that frames come in, and the zoom is logged."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from endocal.jobs.correct import CorrectionSpec, correct
from tests.jobs.lenses import zoom_table
from tests.video.clips import Clip

SIZE = (160, 128)
DIAMETER = 100.0


def disc(number: int, width: int, height: int) -> np.ndarray:
    """A lit circle on black with something to see in it: uint8 (h, w, 3) RGB."""
    x, y = np.meshgrid(np.arange(width), np.arange(height))
    radius = np.hypot(x - (width - 1) / 2, y - (height - 1) / 2)
    rim = np.clip(DIAMETER / 2 + 0.5 - radius, 0, 1)
    light = 150 + 40 * np.sin(x / 11 + number) * np.cos(y / 13)
    return (rim[..., None] * light[..., None] * [1.0, 0.8, 0.7]).clip(0, 255).astype(np.uint8)


@pytest.mark.parametrize(
    ("pix_fmt", "codec"),
    [
        ("yuv420p", "ffv1"),
        ("yuv420p10le", "ffv1"),
        ("gray", "ffv1"),
        ("bgr0", "ffv1"),
        ("bgra", "ffv1"),
        ("gbrp10le", "ffv1"),
        ("rgb24", "png"),
        ("uyvy422", "rawvideo"),
    ],
)
def test_the_circle_is_found_in_every_format(tmp_path: Path, pix_fmt: str, codec: str) -> None:
    clip = Clip(frames=6, size=SIZE, codec=codec, pix_fmt=pix_fmt, picture=disc)
    source = clip.make(tmp_path / "a.mov" if codec == "png" else tmp_path / "a.nut")
    log = tmp_path / "zoom.csv"
    lens = zoom_table(tmp_path / "zoom.toml", SIZE, (80.0, 120.0))
    report = correct(
        CorrectionSpec(
            str(source),
            str(tmp_path / "out.mkv"),
            lens,
            device="numpy",
            zoom_log=str(log),
        )
    )
    assert report.frames == 6
    rows = list(csv.DictReader(log.open()))
    assert [row["source"] for row in rows] == ["rim"] * 6
    # Half a pixel: the rim is one pixel wide, and chroma or eight bits do not move it.
    assert all(abs(float(row["diameter"]) - DIAMETER) < 0.5 for row in rows)
