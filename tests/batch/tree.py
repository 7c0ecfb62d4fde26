"""A tree of short recordings, with all that a hospital's share may hold."""

from __future__ import annotations

import hashlib
import json
import subprocess
import sys
from fractions import Fraction
from pathlib import Path
from typing import Any

from tests.jobs.lenses import calibration
from tests.video.clips import Clip

# One encoder thread whatever the machine, and no macroblock tree, with which x264 wrote other bytes in 3 % of
# the runs of one tiny clip: so every run writes the same.
OPTIONS = (
    *("--recursive", "--jobs", "2", "--threads", "1"),
    *("--device", "numpy", "--preset", "ultrafast"),
)
BROKEN = ("theatre-1/broken.mp4", "theatre-2/empty.mp4", "notes/consent.txt")


def make_tree(folder: Path, count: int = 40, frames: int = 24) -> Path:
    """Make ``count`` files: 3 broken, 2 interlaced, 1 without sound, the rest as recorders make them."""
    source = folder / "raw"
    for room in ("theatre-1", "theatre-2", "notes"):
        (source / room).mkdir(parents=True)
    common: dict[str, Any] = {"codec": "libx264", "options": {"preset": "ultrafast"}}
    for number in range(count - len(BROKEN)):
        clip = Clip(frames=frames + number % 4, sounds=("deu",), **common)
        if number < 2:
            clip = Clip(frames=frames, interlace="tff", sounds=("deu",), **common)
        elif number == 2:
            clip = Clip(frames=frames, rate=Fraction(30), **common)
        room = "theatre-1" if number % 2 else "theatre-2"
        clip.make(source / room / f"case {number:02}.mp4")
    whole = (source / "theatre-1" / "case 01.mp4").read_bytes()
    (source / BROKEN[0]).write_bytes(b"\0" * 200 + whole[200:900])
    (source / BROKEN[1]).write_bytes(b"")
    (source / BROKEN[2]).write_text("signed")
    return source


def lens(folder: Path) -> str:
    """Save a calibration for all of them."""
    return calibration(folder / "cal.toml", -1.5e-4)


def command(source: Path, out: Path, cal: str, *options: str) -> list[str]:
    """Return the command line of a batch."""
    arguments = [str(source), "--out", str(out), "-c", cal, *OPTIONS, *options]
    return [sys.executable, "-m", "endocal", "batch", *arguments]


def run(source: Path, out: Path, cal: str, *options: str) -> subprocess.CompletedProcess[str]:
    """Run a batch to its end."""
    return subprocess.run(
        command(source, out, cal, *options), capture_output=True, text=True, check=False
    )


def events(stderr: str) -> list[dict[str, Any]]:
    """Return the JSON lines of a run."""
    return [json.loads(line) for line in stderr.splitlines() if line.startswith("{")]


def outputs(out: Path) -> dict[str, str]:
    """Return the SHA-256 of each output, and of whatever else lies in the tree, by its place."""
    return {
        str(path.relative_to(out)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(out.rglob("*"))
        if path.is_file() and ".endocal/" not in str(path) and "batch-report" not in path.name
    }


def recorded(out: Path) -> list[dict[str, Any]]:
    """Return the report's recordings without what differs from run to run: times, and who did it."""
    recordings = json.loads((out / "batch-report.json").read_text())["recordings"]
    for recording in recordings:
        for key in ("seconds", "fps", "now"):
            recording.pop(key, None)
    return recordings
