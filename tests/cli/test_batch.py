"""``endocal batch`` as a command: options, what it prints, how it exits."""

from __future__ import annotations

import json
import os
import pty
import subprocess
import sys
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from typing import Any

import pytest

from tests.batch.local import Batch, make_batch

Runner = Callable[..., Any]


@pytest.fixture
def batch(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Batch:
    return make_batch(tmp_path, monkeypatch)


def arguments(batch: Batch, *options: str) -> list[str]:
    places = (
        str(batch.folder / "raw"),
        "--out",
        str(batch.out),
        "-c",
        str(batch.folder / "cal.toml"),
    )
    return ["batch", *places, "-r", "--device", "numpy", *options]


def test_elsewhere_than_on_a_terminal_it_speaks_json_lines(endocal: Runner, batch: Batch) -> None:
    (batch.folder / "raw" / "note.txt").write_text("no video")
    done = endocal(*arguments(batch))
    assert (done.code, done.out) == (1, "")
    events = [json.loads(line) for line in done.err.splitlines()]
    assert [e["event"] for e in events] == [
        "plan",
        *["start", "done"] * 2,
        "start",
        "failed",
        "end",
    ]
    assert events[-2]["output"] == "note.txt"
    assert (events[-1]["done"], events[-1]["failed"]) == (2, 1)
    for name in ("batch-report.json", "batch-report.html"):
        assert "note.txt" in (batch.out / name).read_text()


def test_quiet_says_what_failed_and_json_gives_the_report(endocal: Runner, batch: Batch) -> None:
    done = endocal(*arguments(batch, "--quiet", "--json"))
    assert (done.code, done.err) == (0, "")
    assert json.loads(done.out)["counts"]["done"] == 2
    (batch.folder / "raw" / "note.txt").write_text("no video")
    done = endocal(*arguments(batch, "--quiet"))
    assert (done.code, done.out) == (1, "")
    first, last = done.err.splitlines()
    assert first.startswith("endocal: failed: ")
    assert "note.txt: cannot be read as a video" in first
    assert last.startswith("endocal: 2 of 3 recordings are done (0 by this run), 1 failed")


def test_a_dry_run_prints_the_plan_and_touches_nothing(endocal: Runner, batch: Batch) -> None:
    done = endocal(*arguments(batch, "--dry-run"))
    digest = sha256((batch.folder / "cal.toml").read_bytes()).hexdigest()
    lens = f"with {batch.folder}/cal.toml (sha256 {digest[:12]})"
    lines = [f"do     a.mkv: new; {lens}", f"do     deep/b.mkv: new; {lens}"]
    assert (done.code, done.out.splitlines()) == (0, lines)
    assert "2 of 2 recordings have work; nothing was touched" in done.err
    assert not batch.out.exists()
    endocal(*arguments(batch))
    done = endocal(*arguments(batch, "--dry-run", "--json", "--redo"))
    rows = [json.loads(line) for line in done.out.splitlines()]
    assert [(r["action"], r["output"], r["reason"]) for r in rows] == [
        ("do", "a.mkv", "--redo"),
        ("do", "deep/b.mkv", "--redo"),
    ]
    assert {r["calibration"] for r in rows} == {f"{batch.folder}/cal.toml"}
    assert {r["calibration_sha256"] for r in rows} == {digest}


def test_the_calibration_of_each_recording_is_told(endocal: Runner, batch: Batch) -> None:
    (batch.folder / "m.toml").write_text(
        'schema = "endocal.manifest/1"\n[[scope]]\nserial = "b"\ncalibration = "cal.toml"\n'
        '[[recording]]\nfiles = "raw/deep/{serial}.mkv"\n'
    )
    given = ("batch", str(batch.folder / "m.toml"), "--out", str(batch.out))
    (row,) = endocal(*given, "--dry-run").out.splitlines()
    assert row.startswith(f"do     raw/deep/b.mkv: new; with {batch.folder}/cal.toml (sha256 ")
    assert row.endswith("), serial b")
    done = endocal(*given, "--device", "numpy", "--json")
    (recording,) = json.loads(done.out)["recordings"]
    digest = sha256((batch.folder / "cal.toml").read_bytes()).hexdigest()
    told = [recording[k] for k in ("calibration", "calibration_sha256", "serial")]
    assert told == [f"{batch.folder}/cal.toml", digest, "b"]
    page = (batch.out / "batch-report.html").read_text()
    assert digest in page
    assert "cal.toml (serial b)" in page


def test_a_dry_run_fails_for_what_is_missing(endocal: Runner, batch: Batch) -> None:
    (batch.folder / "m.csv").write_text("files,calibration\nraw/a.mkv,cal.toml\ngone,cal.toml\n")
    done = endocal("batch", str(batch.folder / "m.csv"), "--out", str(batch.out), "--dry-run")
    assert done.code == 1
    assert done.out.startswith("do     raw/a.mkv: new; with ")
    assert "gone (line 3): no such file" in done.err
    assert "1 recording is missing" in done.err


def test_it_takes_the_options_of_correct(endocal: Runner, batch: Batch) -> None:
    options = ("--codec", "libx264", "--preset", "ultrafast", "--suffix", ".mp4", "--size", "32x24")
    done = endocal(*arguments(batch, *options, "--json"))
    assert done.code == 0, done.err
    for recording in json.loads(done.out)["recordings"]:
        assert recording["codec"] == "libx264"
        assert recording["output"].endswith(".mp4")
        assert recording["size_out"] == [32, 24]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--jobs", "0"), "--jobs 0: it is 1 or more"),
        (("--jobs", "2", "--scheduler", "tcp://x"), "--jobs is for this machine"),
        (("--redo", "--retry-failed"), "exclude each other"),
        (("--patience", "0"), "--patience 0: it is more than 0 minutes"),
        (("--suffix", "mkv"), "in a batch it is a suffix"),
        (("--zoom-log", "zoom.csv"), "in a batch it is a suffix"),
        (("--view", "all"), "--view all: it is one of same, crop, full"),
        (("--interpolation", "x"), "--interpolation x: it is one of"),
        (("--codec", "libx262"), "--codec libx262: no such encoder"),
        (("--suffix", ".xyz"), "--suffix .xyz: names no video file"),
        (("--suffix", ".png"), "--suffix .png: names no video file"),
        (("--suffix", ".webm", "--codec", "libx264"), "webm takes no video of libx264"),
        (("--zoom-log", ".xyz"), "--zoom-log .xyz: a zoom log is .csv"),
        (("--crf", "99"), "--crf 99: libx264 takes 0 to 51"),
        (("--preset", "nope"), "--preset nope: libx264 has ultrafast"),
        (("--codec", "libsvtav1", "--preset", "nope"), "--preset nope: libsvtav1 has numbers"),
        (("--size", "64"), "is no size"),
        (("--size", "64x64", "--scale", "2"), "exclude each other"),
        (("--zoom-log", ".csv"), "needs a zoom table"),
        (("-c", "a.toml", "-c", "b.toml"), "--config is given once, or twice"),
    ],
)
def test_wrong_options_start_nothing(
    endocal: Runner, batch: Batch, options: tuple[str, ...], words: str
) -> None:
    for more in ((), ("--dry-run",)):
        assert words in endocal(*arguments(batch, *options, *more)).fails(2)
        assert not batch.out.exists()


def test_wrong_devices_and_places_start_nothing(endocal: Runner, batch: Batch) -> None:
    given = [a if a != "numpy" else "no such device" for a in arguments(batch)]
    assert "no OpenCL device" in endocal(*given).fails(2)
    assert "no OpenCL device" in endocal(*given, "--dry-run").fails(2)
    assert not batch.out.exists()
    given = [
        a if a != str(batch.out) else str(batch.folder / "cal.toml" / "x") for a in arguments(batch)
    ]
    assert "cannot be made: Not a directory" in endocal(*given).fails(1)
    lens = batch.folder / "cal.toml"
    line = endocal(*arguments(batch, "--state", str(lens))).fails(1)
    assert f"{lens}: cannot be made: File exists" in line


def test_a_second_batch_is_told_of_the_first(endocal: Runner, batch: Batch) -> None:
    import fcntl

    endocal(*arguments(batch))
    holder = '{"run": "x", "pid": 1, "host": "elsewhere", "since": "today"}'
    lock = batch.out / ".endocal" / "lock"
    lock.write_text(holder)
    with lock.open("r+") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        line = endocal(*arguments(batch)).fails(1)
        assert "another batch is at work here (process 1 on elsewhere, since today)" in line
        # Looking is allowed.
        assert endocal(*arguments(batch, "--dry-run")).code == 0
    assert endocal(*arguments(batch)).code == 0


def test_on_a_terminal_it_shows_bars(batch: Batch) -> None:
    (batch.folder / "raw" / "[red]note.txt").write_text("no video")
    terminal, theirs = pty.openpty()
    with subprocess.Popen(
        [sys.executable, "-m", "endocal", *arguments(batch, "--jobs", "1")],
        stderr=theirs,
        env={**os.environ, "TERM": "xterm", "COLUMNS": "160"},
    ) as process:
        os.close(theirs)
        said = b""
        while True:
            try:
                said += os.read(terminal, 4096)
            except OSError:  # what Linux answers at the end
                break
    os.close(terminal)
    text = said.decode()
    assert process.returncode == 1
    assert "3 of 3 recordings have work; 1 process" in text
    assert "3/3 recordings, 1 failed" in text
    assert "[red]note.txt: cannot be read" in text
    assert "endocal: 2 of 3 recordings are done (2 by this run), 1 failed" in text
    assert "Traceback" not in text
