"""``endocal correct`` as a program: pipes, signals, output, memory."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import av
import cv2
import numpy as np
import pytest

from tests.jobs.lenses import calibration
from tests.video.clips import Clip, contents

Runner = Callable[..., Any]

DELIVERY = Clip(frames=12, codec="libx264", options={"preset": "ultrafast"}, sounds=("deu",))
ENDOCAL = (sys.executable, "-m", "endocal", "correct")


@pytest.fixture
def lens(tmp_path: Path) -> str:
    return calibration(tmp_path / "cal.toml", -1.5e-4)


def test_a_video_is_corrected_and_the_summary_goes_to_stderr(
    endocal: Runner, tmp_path: Path, lens: str
) -> None:
    source, out = DELIVERY.make(tmp_path / "a.mp4"), tmp_path / "out.mp4"
    done = endocal("correct", source, "-o", out, "-c", lens, "--device", "numpy")
    assert (done.code, done.out) == (0, "")
    assert "12 frames of 64x48, libx264" in done.err
    assert contents(out).times == pytest.approx(contents(source).times)


def test_json_is_the_report_alone(endocal: Runner, tmp_path: Path, lens: str) -> None:
    source, out = DELIVERY.make(tmp_path / "a.mp4"), tmp_path / "out.mp4"
    options = ("--json", "--quiet", "--device", "numpy")
    done = endocal("correct", source, "-o", out, "-c", lens, *options)
    report = json.loads(done.out)
    assert (report["frames"], report["damaged"], report["size_out"]) == (12, 0, [64, 48])
    assert done.err == ""
    done = endocal("correct", source, "-o", "-", "-c", lens, "--json")
    assert "write to stdout" in done.fails(2)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--size", "64"), "is no size"),
        (("--codec-option", "tune"), "write KEY=VALUE"),
        (("--codec-option", "nosuch=1"), "has no such option"),
        (("--format", "nosuch"), "names no video file"),
        (("--format", "hls"), "names no video file"),
        (("--format", "image2"), "names no video file"),
        (("--format", "mkv"), "its suffix names mp4, and --format matroska"),
        (("--device", "nosuch"), "no OpenCL device matches"),
        (("--size", "63x47"), "give --size 62x46"),
        (("--codec", "aac"), "encodes audio"),
    ],
)
def test_wrong_options(
    endocal: Runner, tmp_path: Path, lens: str, options: tuple[str, ...], words: str
) -> None:
    source, out = DELIVERY.make(tmp_path / "a.mp4"), tmp_path / "out.mp4"
    device = () if "--device" in options else ("--device", "numpy")
    done = endocal("correct", source, "-o", out, "-c", lens, *device, *options)
    assert words in done.fails(2)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.mp4", "cal.toml"]


@pytest.mark.parametrize(("name", "named"), [("o.m4v", "mp4"), ("o.mkv", "mkv"), ("o.dat", "mkv")])
def test_a_format_that_the_suffix_does_not_contradict(
    endocal: Runner, tmp_path: Path, lens: str, name: str, named: str
) -> None:
    source, out = DELIVERY.make(tmp_path / "a.mp4"), tmp_path / name
    options = ("-c", lens, "--device", "numpy", "--format", named)
    assert endocal("correct", source, "-o", out, *options).code == 0
    assert out.exists()


@pytest.mark.parametrize("name", ["o.png", "o%03d.jpg", "o.m3u8", "o.mpd", "o", "o.toml"])
def test_a_video_goes_into_one_video_file(
    endocal: Runner, tmp_path: Path, lens: str, name: str
) -> None:
    source = DELIVERY.make(tmp_path / "a.mp4")
    done = endocal("correct", source, "-o", tmp_path / name, "-c", lens, "--device", "numpy")
    assert "use one such as .mp4, .mkv" in done.fails(2)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.mp4", "cal.toml"]


def test_an_encoder_that_refuses_says_why(endocal: Runner, tmp_path: Path, lens: str) -> None:
    """The frames' own odd size is the recording's fault, not the command line's."""
    source = Clip(frames=3, size=(63, 47)).make(tmp_path / "a.mkv")
    odd = calibration(tmp_path / "odd.toml", -1.5e-4, (30.0, 25.0), (63, 47))
    done = endocal(
        *("correct", source, "-o", tmp_path / "out.mp4", "-c", odd, "--device", "numpy"),
        *("--codec", "libx264"),
    )
    assert "libx264 does not take 63x47 frames in yuv420p" in done.fails(1)
    assert not (tmp_path / "out.mp4").exists()


def test_a_picture_keeps_its_transparency(endocal: Runner, tmp_path: Path) -> None:
    """A column of alpha 0 goes where its colours go; outside the picture nothing shines through."""
    lens = calibration(tmp_path / "cal.toml", -1.5e-4, (31.5, 23.5))
    picture = np.full((48, 64, 4), 200, np.uint8)
    picture[..., 3] = 255
    picture[:, 28:36, 3] = 0
    cv2.imwrite(str(tmp_path / "a.png"), picture)
    for name in ("o.png", "o.tif"):
        done = endocal("correct", tmp_path / "a.png", "-o", tmp_path / name, "-c", lens)
        assert done.code == 0, done.err
        out = cv2.imread(str(tmp_path / name), cv2.IMREAD_UNCHANGED)
        assert out.shape == (48, 64, 4)
        assert out[24, 32, 3] == 0
        assert (out[[0, 0, -1, -1], [0, -1, 0, -1], 3] == 255).all()
        assert "transparency" not in done.err
    done = endocal("correct", tmp_path / "a.png", "-o", tmp_path / "o.jpg", "-c", lens)
    assert done.code == 0
    assert "note: .jpg holds no transparency" in done.err


def test_a_picture_that_is_damaged_in_the_middle_is_refused_in_our_words(
    endocal: Runner, tmp_path: Path, lens: str, capfd: pytest.CaptureFixture[str]
) -> None:
    noise = np.random.default_rng(2).integers(0, 255, (48, 64, 3)).astype(np.uint8)
    data = cv2.imencode(".jpg", noise)[1].tobytes()
    (tmp_path / "a.jpg").write_bytes(data[:2500] + data[2700:])
    done = endocal("correct", tmp_path / "a.jpg", "-o", tmp_path / "o.png", "-c", lens)
    assert "a.jpg: is damaged in the middle" in done.fails(1)
    assert not (tmp_path / "o.png").exists()
    assert capfd.readouterr().err == "", "libjpeg's own line is kept back"


@pytest.mark.parametrize(("name", "options"), [("o.png", ()), ("o.jpg", ("--side-by-side",))])
def test_a_picture_goes_through_the_same_command(
    endocal: Runner, tmp_path: Path, lens: str, name: str, options: tuple[str, ...]
) -> None:
    picture = np.full((48, 64, 3), 180, np.uint8)
    cv2.imwrite(str(tmp_path / "a.png"), picture)
    out = tmp_path / name
    done = endocal("correct", tmp_path / "a.png", "-o", out, "-c", lens, *options)
    assert done.code == 0, done.err
    width = 128 if options else 64
    assert cv2.imread(str(out)).shape == (48, width, 3)


def test_pictures_flow_through_pipes(endocal: Runner, tmp_path: Path, lens: str) -> None:
    data = cv2.imencode(".png", np.full((48, 64), 90, np.uint8))[1].tobytes()
    done = endocal("correct", "-", "-o", "-", "-c", lens, stdin=data)
    assert done.code == 0, done.err
    assert cv2.imdecode(np.frombuffer(done.output, np.uint8), cv2.IMREAD_UNCHANGED).shape == (
        48,
        64,
    )
    done = endocal("correct", "-", "-o", tmp_path / "out.mp4", "-c", lens, stdin=data)
    assert "a picture is written as" in done.fails(2)
    line = endocal("correct", "-", "-o", "-", "-c", lens).fails(1)
    assert "stdin: is empty: see what the command before the pipe says" in line


@pytest.mark.parametrize(
    ("name", "container", "out"),
    [
        ("a.mkv", "matroska", "matroska"),
        ("a.ts", "mpegts", "mpegts"),
        ("a.y4m", "yuv4mpegpipe", "yuv4mpegpipe"),
        ("a.mkv", "matroska", "y4m"),
    ],
)
def test_videos_flow_through_pipes(
    endocal_process: Runner, tmp_path: Path, lens: str, name: str, container: str, out: str
) -> None:
    clip = DELIVERY if name != "a.y4m" else Clip(codec="rawvideo")
    source = clip.make(tmp_path / name, container)
    named = ("--format", out) if out == "y4m" else ()
    options = ("--device", "numpy", *named)
    done = endocal_process(
        "correct", "-", "-o", "-", "-c", lens, *options, stdin=source.read_bytes()
    )
    assert done.code == 0, done.err
    (tmp_path / "result").write_bytes(done.output)
    after = contents(tmp_path / "result", "yuv4mpegpipe" if out == "y4m" else out)
    assert len(after.frames) == 12
    assert after.times == pytest.approx(contents(source, container).times, abs=1e-3)
    assert ("audio" in after.types) == (out in ("matroska", "mpegts"))


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="needs the ffmpeg command at both ends")
def test_between_two_ffmpegs(tmp_path: Path, lens: str) -> None:
    """The y4m pipe of the manual; the last one counts what it gets."""
    source = DELIVERY.make(tmp_path / "a.mp4")
    quiet = ("ffmpeg", "-v", "error", "-i")
    first = subprocess.Popen(
        [*quiet, str(source), "-f", "yuv4mpegpipe", "-"], stdout=subprocess.PIPE
    )
    second = subprocess.Popen(
        [*ENDOCAL, "-", "-o", "-", "-c", lens, "--device", "numpy", "-q"],
        stdin=first.stdout,
        stdout=subprocess.PIPE,
    )
    third = subprocess.run(
        [*quiet, "-", "-f", "framemd5", "-"], stdin=second.stdout, capture_output=True, check=True
    )
    assert (first.wait(), second.wait()) == (0, 0)
    lines = [line for line in third.stdout.decode().splitlines() if not line.startswith("#")]
    assert len(lines) == 12


@pytest.mark.parametrize("name", ["a.mkv", "a.png"])
def test_a_named_pipe_is_read_once(endocal: Runner, tmp_path: Path, lens: str, name: str) -> None:
    """As the shell makes of ``<(command)``: nothing of it may be lost in finding out what it holds."""
    if name == "a.png":
        cv2.imwrite(str(tmp_path / name), np.full((48, 64), 90, np.uint8))
    else:
        DELIVERY.make(tmp_path / name)
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    data = (tmp_path / name).read_bytes()
    threading.Thread(target=pipe.write_bytes, args=(data,), daemon=True).start()
    out = tmp_path / f"out{Path(name).suffix}"
    done = endocal("correct", pipe, "-o", out, "-c", lens, "--device", "numpy")
    assert done.code == 0, done.err
    assert out.exists()


def test_a_reader_that_leaves_ends_it_quietly(tmp_path: Path, lens: str) -> None:
    source = Clip(frames=200).make(tmp_path / "a.mkv")
    process = subprocess.Popen(
        [*ENDOCAL, str(source), "-o", "-", "--format", "y4m", "-c", lens, "--device", "numpy"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    assert process.stdout is not None
    process.stdout.read(1000)
    process.stdout.close()
    assert process.stderr is not None
    assert process.stderr.read() == b""
    assert process.wait(timeout=30) == 0


@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 128 + signal.SIGTERM)]
)
def test_a_signal_ends_it_and_leaves_no_file(
    tmp_path: Path, lens: str, number: signal.Signals, code: int
) -> None:
    """While it waits for more input, its temporary file open."""
    data = Clip(frames=100).make(tmp_path / "a.mkv").read_bytes()
    out = tmp_path / "out"
    out.mkdir()
    process = subprocess.Popen(
        [*ENDOCAL, "-", "-o", str(out / "x.mkv"), "-c", lens, "--device", "numpy"],
        stdin=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    assert process.stdin is not None
    process.stdin.write(data[: len(data) // 2])
    process.stdin.flush()
    deadline = time.monotonic() + 60
    while not list(out.iterdir()) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert list(out.iterdir()), "it has begun to write"
    process.send_signal(number)
    assert process.wait(timeout=30) == code
    assert list(out.iterdir()) == []
    process.stdin.close()


def test_a_full_disk_is_an_error_and_leaves_no_file(tmp_path: Path, lens: str) -> None:
    resource = pytest.importorskip("resource")
    source = Clip(frames=60).make(tmp_path / "a.mkv")
    out = tmp_path / "out"
    out.mkdir()
    limit = 20_000
    done = subprocess.run(
        [*ENDOCAL, str(source), "-o", str(out / "x.mkv"), "-c", lens, "--device", "numpy"],
        capture_output=True,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)),
        check=False,
    )
    message = done.stderr.decode()
    assert done.returncode == 1, message
    assert "cannot be written" in message
    assert len(message.splitlines()) == 1
    assert list(out.iterdir()) == []


def test_memory_does_not_grow_with_the_length(tmp_path: Path) -> None:
    """Ten times the frames, the same peak: a frame is 1.4 MB, and 90 more of them go through."""
    size = (1280, 720)
    lens = calibration(tmp_path / "cal.toml", -1e-7, (640, 360), size)
    clip = Clip(size=size, codec="libx264", options={"preset": "ultrafast"}, picture=_flat)
    peaks = []
    for frames in (10, 100):
        clip.frames = frames
        source = clip.make(tmp_path / f"{frames}.mp4")
        command = [*ENDOCAL, str(source), "-o", str(tmp_path / f"out{frames}.mp4"), "-c", lens]
        script = (
            "import resource, subprocess, sys; subprocess.run(sys.argv[1:], check=True);"
            "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)"
        )
        done = subprocess.run(
            [sys.executable, "-c", script, *command, "-q", "--preset", "ultrafast"],
            capture_output=True,
            check=True,
        )
        peaks.append(int(done.stdout) / 1024)
    # The threads fill their queues once, some 10 frames; 90 frames kept would be 125 MB.
    assert peaks[1] - peaks[0] < 40, peaks


def _flat(number: int, width: int, height: int) -> np.ndarray:
    return np.full((height, width, 3), 60 + number, np.uint8)


def test_the_real_recording_keeps_its_frames_and_times(
    endocal: Runner, tmp_path: Path, real_data: Path
) -> None:
    source, out = real_data / "endoscopy" / "laparoscopy_1280x720.mp4", tmp_path / "out.mp4"
    lens = calibration(tmp_path / "cal.toml", -6e-7, (640, 360), (1280, 720))
    done = endocal("correct", source, "-o", out, "-c", lens, "--preset", "ultrafast")
    assert done.code == 0, done.err
    times = []
    for path in (source, out):
        with av.open(str(path)) as file:
            times.append([(p.pts, p.time_base) for p in file.demux(video=0) if p.size])
    assert len(times[0]) == len(times[1]) == 250
    assert sorted(times[0]) == sorted(times[1])
