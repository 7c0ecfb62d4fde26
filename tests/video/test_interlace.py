"""Seeing interlacing, and parting the fields."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from endocal.video.frames import plane_views
from endocal.video.interlace import Deinterlacer, field_order, may_be_interlaced
from endocal.video.reader import VideoReader, is_frame
from tests.video.clips import Clip, drifting

WIDE = (160, 96)


def pan(number: float, width: int = 240, height: int = 144) -> np.ndarray:
    """Luma of a textured scene that moves 2 px a field to the right, uint8."""
    x, y = np.meshgrid(np.arange(width), np.arange(height))
    x = x - 2.0 * number
    wave = np.sin(x / 3.1) * np.sin(y / 4.3) + 0.6 * np.sin((x + y) / 7)
    return (120 + 55 * wave).clip(0, 255).astype(np.uint8)


def woven(first: str, number: int) -> np.ndarray:
    early, late = pan(2 * number), pan(2 * number + 1)
    upper, lower = (early, late) if first == "tff" else (late, early)
    frame = upper.copy()
    frame[1::2] = lower[1::2]
    return frame


@pytest.mark.parametrize("first", ["tff", "bff"])
@pytest.mark.parametrize("noise", [0, 6])
@pytest.mark.parametrize("bits", [8, 10])
def test_the_first_field_is_found(first: str, noise: int, bits: int) -> None:
    rng = np.random.default_rng(4)
    frames = [
        (woven(first, i) + rng.normal(0, noise, (144, 240))).clip(0, 255).astype(np.uint16)
        << bits - 8
        for i in range(6)
    ]
    assert field_order([frames], bits) == first


@pytest.mark.parametrize("noise", [0, 6])
def test_whole_frames_are_not_taken_for_woven_ones(noise: int) -> None:
    rng = np.random.default_rng(5)
    moving = [
        (pan(2 * i) + rng.normal(0, noise, (144, 240))).clip(0, 255).astype(np.uint8)
        for i in range(6)
    ]
    still = [np.rot90(pan(0)).copy()] * 6
    # Fine lines, one row light and one dark, are static detail and no comb.
    lines = np.tile(np.array([[40], [200]], np.uint8), (72, 240))
    assert field_order([moving]) is None
    assert field_order([still]) is None
    assert field_order([[np.roll(lines, 2 * i, axis=1) for i in range(6)]]) is None
    assert field_order([]) is None


@pytest.mark.parametrize("path", ["lap"])
def test_a_real_recording_is_progressive(real_data: Path, path: str) -> None:
    with VideoReader(
        str(real_data / "endoscopy" / "laparoscopy_1280x720.mp4"), name=path
    ) as reader:
        runs = [[plane_views(f)[0] for f in run] for run in reader.samples()]
    assert field_order(runs) is None


def clip(tmp_path: Path, interlace: str) -> Path:
    return Clip(frames=10, size=WIDE, interlace=interlace, codec="ffv1").make(tmp_path / "a.mkv")


def test_frames_keep_their_number_and_times(tmp_path: Path) -> None:
    with VideoReader(str(clip(tmp_path, "tff")), name="a") as reader:
        assert may_be_interlaced(reader.info)
        deinterlacer = Deinterlacer(reader.info, order="tff")
        frames = [f for f in deinterlacer.apply(reader.items()) if is_frame(f)]
        times = [f.time for f in frames]
    # Matroska counts milliseconds.
    assert times == pytest.approx([i / 25 for i in range(10)], abs=1e-3)
    assert not any(f.interlaced_frame for f in frames)


def test_fields_come_at_double_rate(tmp_path: Path) -> None:
    with VideoReader(str(clip(tmp_path, "tff")), name="a") as reader:
        deinterlacer = Deinterlacer(reader.info, order="tff", fields=True)
        assert deinterlacer.time_base == reader.info.time_base / 2
        times = [f.time for f in deinterlacer.apply(reader.items()) if is_frame(f)]
    assert len(times) == 20
    assert np.diff(times) == pytest.approx([1 / 50] * 19, abs=1e-3)


@pytest.mark.parametrize("first", ["tff", "bff"])
def test_the_fields_of_one_time_are_put_together(tmp_path: Path, first: str) -> None:
    """A deinterlaced frame is nearer to the scene at its time than the woven frame, by far."""
    with VideoReader(str(clip(tmp_path, first)), name="a") as reader:
        items = [f for f in reader.items() if is_frame(f)]
        made = list(Deinterlacer(reader.info, order=first).apply(items))
        for i in (3, 5, 7):
            scene = drifting(2 * i, *WIDE).astype(float) @ [0.299, 0.587, 0.114] * 219 / 255 + 16
            error = [
                np.sqrt(np.mean((plane_views(f)[0][8:-8, 8:-8] - scene[8:-8, 8:-8]) ** 2))
                for f in (items[i], made[i])
            ]
            assert error[1] < 0.5 * error[0]


def test_frames_that_are_not_flagged_pass_untouched(tmp_path: Path) -> None:
    with VideoReader(str(clip(tmp_path, "")), name="a") as reader:
        items = list(reader.items())
        deinterlacer = Deinterlacer(reader.info, only_flagged=True)
        assert list(deinterlacer.apply(items)) == items
        assert deinterlacer.frames == 0
