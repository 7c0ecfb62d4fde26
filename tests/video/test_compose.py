"""A made clip comes back as it was made: frames, times, colour, sound."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest

from endocal.errors import OutputError, UsageError
from endocal.synth.sound import RATE, sound_track
from endocal.video.compose import compose

SIZE = (160, 128)


def pictures(count: int) -> list[np.ndarray]:
    """Even pictures that grow brighter, with a tint."""
    return [
        np.full((SIZE[1], SIZE[0], 3), (40 + 4 * i, 60 + 4 * i, 80 + 4 * i), np.uint8)
        for i in range(count)
    ]


def test_frames_come_back_in_time_and_colour(tmp_path: Path) -> None:
    path = tmp_path / "clip.mp4"
    rate = Fraction(30000, 1001)
    assert compose(str(path), pictures(20), SIZE, rate, crf=10) == 20
    with av.open(str(path)) as container:
        frames = list(container.decode(video=0))
        assert [f.time for f in frames] == pytest.approx([float(i / rate) for i in range(20)])
        assert {(f.color_range, f.colorspace, f.color_primaries) for f in frames} == {(1, 1, 1)}
        for frame, made in zip(frames, pictures(20), strict=True):
            # BT.709 in eight bits and limited range, there and back: two levels.
            assert np.abs(frame.to_ndarray(format="bgr24").astype(int) - made).max() <= 3


def test_sound_keeps_time_with_the_pictures(tmp_path: Path) -> None:
    path = tmp_path / "clip.mp4"
    sound = sound_track("clicks", 3.0)
    compose(str(path), pictures(30), SIZE, Fraction(10), sound, RATE)
    with av.open(str(path)) as container:
        assert container.streams.audio[0].codec_context.sample_rate == RATE
        blocks = [(f.time, f.to_ndarray()[0]) for f in container.decode(audio=0)]
    heard = np.zeros(4 * RATE)
    for start, block in blocks:
        first = max(round(start * RATE), 0)
        heard[first : first + len(block)] = block[-len(block) :]
    for second in range(3):
        around = heard[max(second * RATE - 2000, 0) : second * RATE + 2000]
        loudest = np.abs(around).argmax() + max(second * RATE - 2000, 0)
        # The loudest swing of the click is its first, a quarter of a millisecond after it begins.
        assert abs(loudest / RATE - second) < 0.002


def test_the_same_pictures_give_the_same_bytes(tmp_path: Path) -> None:
    made = []
    for name in ("a.mp4", "b.mp4"):
        compose(str(tmp_path / name), pictures(5), SIZE, Fraction(25), sound_track("sweep", 0.2))
        made.append((tmp_path / name).read_bytes())
    assert made[0] == made[1]


def test_what_cannot_be_written_is_said(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="even"):
        compose(str(tmp_path / "x.mp4"), [], (161, 128), Fraction(25))
    with pytest.raises(UsageError, match="suffix"):
        compose(str(tmp_path / "x.nothing"), [], SIZE, Fraction(25))
    with pytest.raises(OutputError, match=r"clip\.mp4: cannot be written"):
        compose(str(tmp_path / "no" / "x.mp4"), pictures(1), SIZE, Fraction(25), name="clip.mp4")
