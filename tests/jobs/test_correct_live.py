"""A live input: read as it comes, never queued, ended by an interrupt."""

from __future__ import annotations

import io
import signal
import socket
import subprocess
import sys
import threading
import time
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import av
import pytest

from endocal.errors import InputError
from endocal.jobs.correct import CorrectionReport, CorrectionSpec, correct
from endocal.video.live import is_address, redacted
from endocal.video.pipeline import run
from endocal.video.reader import VideoReader
from tests.jobs.lenses import calibration
from tests.video.clips import Clip, contents

CLIP = Clip(
    frames=50,
    codec="libx264",
    options={"preset": "ultrafast", "g": "10"},
    sounds=("deu",),
    time_base=Fraction(1, 90000),
    pts=[900_000 + 3600 * i for i in range(50)],
)


class Camera:
    """Sends a transport stream at its own pace over TCP, and again, until it is closed."""

    def __init__(self, data: bytes, times: int = 1) -> None:
        self._data, self._times = data, times
        self._socket = socket.create_server(("127.0.0.1", 0))
        self.address = f"tcp://127.0.0.1:{self._socket.getsockname()[1]}"
        self._closed = threading.Event()
        threading.Thread(target=self._send, daemon=True).start()

    def _send(self) -> None:
        connection, _ = self._socket.accept()
        with connection:
            for _ in range(self._times):
                step = len(self._data) // 50
                for start in range(0, len(self._data), step):
                    if self._closed.wait(0.02):
                        return
                    try:
                        connection.sendall(self._data[start : start + step])
                    except OSError:
                        return

    def close(self) -> None:
        self._closed.set()
        self._socket.close()


def correct_live(tmp_path: Path, address: str) -> CorrectionReport:
    lens = calibration(tmp_path / "cal.toml", -1.5e-4)
    return correct(
        CorrectionSpec(address, str(tmp_path / "out.mkv"), lens, device="numpy", live=True)
    )


def test_a_stream_is_corrected_as_it_comes(tmp_path: Path) -> None:
    camera = Camera(CLIP.make(tmp_path / "a.ts").read_bytes())
    report = correct_live(tmp_path, camera.address)
    camera.close()
    after = contents(tmp_path / "out.mkv")
    assert report.latency is not None
    assert report.frames + report.latency.dropped == pytest.approx(50, abs=3)
    assert report.frames > 10
    assert report.warnings == ()
    # The source's clock stood at 10 s.
    assert 0 <= after.times[0] < 2
    assert after.types == ["video", "audio"]


def test_an_interrupt_ends_it_well(tmp_path: Path) -> None:
    lens = calibration(tmp_path / "cal.toml", -1.5e-4)
    camera = Camera(CLIP.make(tmp_path / "a.ts").read_bytes(), times=100)
    out = tmp_path / "out"
    out.mkdir()
    command = [sys.executable, "-m", "endocal", "correct", camera.address, "--live"]
    process = subprocess.Popen(
        [*command, "-o", str(out / "x.mkv"), "-c", lens, "--device", "numpy"],
        stderr=subprocess.PIPE,
    )
    deadline = time.monotonic() + 60
    while not list(out.iterdir()) and time.monotonic() < deadline:
        time.sleep(0.05)
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=30)
    camera.close()
    assert process.returncode == 0, err
    assert b"latency" in err
    assert [p.name for p in out.iterdir()] == ["x.mkv"]
    assert contents(out / "x.mkv").frames


def test_frames_are_left_out_rather_than_queued() -> None:
    """A source far quicker than the sink: what comes out is what was newest."""
    dropped: list[int] = []
    out: list[int] = []

    def slow(item: int) -> None:
        time.sleep(0.01)
        out.append(item)

    def source() -> object:
        for i in range(200):
            time.sleep(0.0005)
            yield i

    run(source(), lambda n: n, slow, drop=dropped.append)  # type: ignore[arg-type]
    assert len(out) + len(dropped) == 200
    assert dropped
    assert out == sorted(out)
    assert out[-1] == 199


def test_addresses_and_what_is_said_of_them() -> None:
    assert is_address("rtsp://camera/1")
    assert is_address("/dev/video0")
    assert not is_address("a/b.mp4")
    assert redacted("rtsp://jane:secret@camera/1") == "rtsp://camera/1"
    assert redacted("a@b.mp4") == "a@b.mp4"


@pytest.mark.parametrize(
    ("address", "words"),
    [
        ("ftp://127.0.0.1/x", "is no live input"),
        ("tcp://127.0.0.1:9", "cannot be opened"),
        ("/dev/video77", "cannot be opened"),
    ],
)
def test_what_cannot_be_opened(tmp_path: Path, address: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        correct_live(tmp_path, address)
    assert not (tmp_path / "out.mkv").exists()


def test_an_address_is_only_read_when_asked_for(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="--live"):
        VideoReader("rtsp://127.0.0.1/x", name="it")


def test_a_pipe_may_be_live_too(tmp_path: Path) -> None:
    data = replace(CLIP, frames=12, pts=None).make(tmp_path / "a.ts").read_bytes()
    with VideoReader(io.BytesIO(data), name="it", live=True) as reader:
        assert sum(isinstance(item, av.VideoFrame) for item in reader.items()) == 12
