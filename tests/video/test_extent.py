"""Whether a file has its end: told by the sizes in it, so that neither a cut nor an odd time misleads."""

from __future__ import annotations

import os
from fractions import Fraction
from pathlib import Path

import av
import pytest
from av.container import OutputContainer

from endocal.video.extent import is_cut_off
from endocal.video.reader import VideoReader

from .clips import Clip

FRAMES = 50
FRAGMENTED = {"movflags": "frag_keyframe+empty_moov"}


def truncated(path: Path) -> bool:
    with VideoReader(str(path), name="a") as reader:
        list(reader.items())
        return any("breaks off" in fault for fault in reader.faults())


@pytest.mark.parametrize("suffix", [".mkv", ".webm", ".nut", ".wmv", ".mp4", ".mov", ".ts", ".flv"])
def test_a_file_that_begins_late_is_whole(tmp_path: Path, suffix: str) -> None:
    """Some containers count their duration from zero, others from their first frame."""
    codec = {".webm": "libvpx-vp9", ".wmv": "mpeg4"}.get(suffix, "libx264")
    clip = Clip(frames=FRAMES, codec=codec, pts=range(125, 125 + FRAMES))
    path = clip.make(tmp_path / f"a{suffix}", avoid_negative_ts="disabled")
    with VideoReader(str(path), name="a") as reader:
        assert reader.info.start is not None
        assert reader.info.start > 4.9
    assert not truncated(path)


def test_a_last_frame_that_is_shown_for_long_is_no_missing_end(tmp_path: Path) -> None:
    path = tmp_path / "a.mkv"
    with av.open(str(path), "w") as out:
        _write_with_long_last_frame(out)
    with av.open(str(path)) as container:
        assert container.duration is not None
        assert container.duration > 5 * av.time_base
    assert not truncated(path)


@pytest.mark.parametrize("suffix", [".mkv", ".mp4"])
@pytest.mark.parametrize("share", [0.5, 0.95, 0.995])
def test_however_little_is_missing(tmp_path: Path, suffix: str, share: float) -> None:
    clip = Clip(frames=FRAMES, codec="libx264", options={"g": "10"})
    options = FRAGMENTED if suffix == ".mp4" else {}
    path = clip.make(tmp_path / f"a{suffix}", **options)
    assert is_cut_off(str(path)) is False
    assert not truncated(path)
    os.truncate(path, int(path.stat().st_size * share))
    assert is_cut_off(str(path)) is True
    assert truncated(path)


def test_a_recording_that_was_never_finished(tmp_path: Path) -> None:
    """Its segment has no size, but its clusters have; bytes that are no structure tell nothing."""
    whole = Clip(frames=FRAMES).make(tmp_path / "a.mkv").read_bytes()
    path = tmp_path / "b.mkv"
    at = whole.index(b"\x18\x53\x80\x67") + 4
    unknown = whole[:at] + b"\x01" + b"\xff" * 7 + whole[at + 8 :]
    path.write_bytes(unknown)
    assert is_cut_off(str(path)) is False
    cluster = unknown.index(b"\x1f\x43\xb6\x75")
    path.write_bytes(unknown[: cluster + 200])
    assert is_cut_off(str(path)) is True
    path.write_bytes(unknown[: at + 8] + bytes(100))
    assert is_cut_off(str(path)) is None
    path.write_bytes(b"RIFF" + bytes(100))
    assert is_cut_off(str(path)) is None


def _write_with_long_last_frame(out: OutputContainer) -> None:
    stream = out.add_stream("ffv1", rate=25)
    stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
    stream.time_base = Fraction(1, 1000)
    for number in range(5):
        frame = av.VideoFrame(64, 48, "yuv420p")
        frame.pts, frame.time_base = 40 * number, Fraction(1, 1000)
        for packet in stream.encode(frame):
            packet.duration = 40 if number < 4 else 5000
            out.mux(packet)
