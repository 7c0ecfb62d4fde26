"""How long a whole correction takes and how much memory, beside its peers in the same run.

Each contender is a process of its own that reads the same H.264 file and writes another with the same
encoder settings (libx264, ultrafast, crf 18), start-up included. What counts is the time that a correction
adds to a plain transcode.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from fractions import Fraction
from pathlib import Path
from statistics import median
from typing import Any

import cv2
import numpy as np

from ..calibration.result import Calibration
from ..errors import EndocalError
from ..files import save
from ..model import DivisionModel
from ..video.compose import compose

SIZE = (1920, 1080)
FRAMES = 600
ROUNDS = 3
_ENCODER = ("-c:v", "libx264", "-preset", "ultrafast", "-crf", "18", "-c:a", "copy")
# lam R^2, R being half the frame's diagonal, and a k1 of ffmpeg's that bends about as much.
_BEND = -0.3
_LENS = "lenscorrection=k1=-0.2:k2=0.02:i=bilinear"
_SOUND_RATE = 48000

PLAIN = "ffmpeg, plain transcode"
LENS = "ffmpeg, lenscorrection=i=bilinear"
OURS = "endocal correct"
CV2 = "cv2: VideoCapture, remap, VideoWriter (mpeg4, no sound)"


@dataclass(frozen=True)
class Cost:
    """What a run took: seconds on the clock and of all processors, and its peak memory in MiB."""

    seconds: float
    processor: float
    memory: float


@dataclass(frozen=True)
class Row:
    """A contender: medians over the rounds (the largest for memory), and the least seconds on the clock."""

    name: str
    cost: Cost
    least: float


@dataclass(frozen=True)
class CorrectReport:
    """The rows of the contenders that are installed, and what follows from them.

    ``added`` is the time that endocal adds to the plain transcode over what lenscorrection adds, on the
    clock, and ``added_processor`` the same of the processors' time: medians of the rounds' own ratios.
    ``times_plain`` is endocal's time over the plain transcode's. ``short_memory`` is endocal's peak, MiB,
    on a clip a tenth as long. None where a peer is missing; ``missing`` names those.
    """

    size: tuple[int, int]
    frames: int
    rounds: int
    rows: tuple[Row, ...]
    missing: tuple[str, ...]
    added: float | None
    added_processor: float | None
    times_plain: float | None
    short_memory: float

    def data(self) -> dict[str, Any]:
        """Return the report as plain data."""
        return asdict(self)


def run(
    size: tuple[int, int] = SIZE,
    frames: int = FRAMES,
    rounds: int = ROUNDS,
    device: str = "auto",
    progress: Callable[[str], None] = lambda message: None,
) -> CorrectReport:
    """Make a clip and let every contender that is installed correct it, in turn, ``rounds`` times.

    Raises EndocalError where one of them fails.
    """
    with tempfile.TemporaryDirectory(prefix="endocal-bench-") as folder:
        place = Path(folder)
        progress(f"making a clip of {frames} frames")
        clip = _make_clip(place / "clip.mp4", size, frames)
        short = _make_clip(place / "short.mp4", size, max(frames // 10, 1))
        commands, missing = _contenders(place, clip, size, device)
        costs: dict[str, list[Cost]] = {name: [] for name in commands}
        for number in range(rounds):
            for name, command in commands.items():
                progress(f"round {number + 1} of {rounds}: {name}")
                costs[name].append(_measure(command))
        brief = _measure([str(short) if part == str(clip) else part for part in commands[OURS]])
    return CorrectReport(
        size,
        frames,
        rounds,
        tuple(_row(name, each) for name, each in costs.items()),
        missing,
        _added(costs, "seconds"),
        _added(costs, "processor"),
        _ratio(costs),
        brief.memory,
    )


def _contenders(
    place: Path, clip: Path, size: tuple[int, int], device: str
) -> tuple[dict[str, list[str]], tuple[str, ...]]:
    """Return the command lines by name, and the names of the peers that are not installed."""
    w, h = size
    lam = _BEND / ((w / 2) ** 2 + (h / 2) ** 2)
    model = DivisionModel(lam, ((w - 1) / 2, (h - 1) / 2), size)
    lens = place / "lens.toml"
    save(Calibration(model), lens)
    ours = [sys.executable, "-m", "endocal", "correct", str(clip), "-o", str(place / "ours.mp4")]
    ours += ["-c", str(lens), "--overwrite", "--quiet", "--device", device]
    ours += ["--codec", "libx264", "--preset", "ultrafast", "--crf", "18"]
    commands: dict[str, list[str]] = {}
    ffmpeg = shutil.which("ffmpeg")
    if ffmpeg is not None:
        start = [ffmpeg, "-v", "error", "-y", "-i", str(clip)]
        commands[PLAIN] = [*start, *_ENCODER, str(place / "plain.mp4")]
        commands[LENS] = [*start, "-vf", _LENS, *_ENCODER, str(place / "lens.mp4")]
    commands[OURS] = ours
    script = [sys.executable, "-m", "endocal.benchmarks.cv2_video", str(clip)]
    commands[CV2] = [*script, str(place / "cv2.mp4"), repr(lam)]
    return commands, () if ffmpeg else (PLAIN, LENS)


# A process's peak memory counts from that of the process which started it. So a small one does.
_LAUNCHER = """
import json, resource, subprocess, sys, time
began = time.monotonic()
done = subprocess.run(sys.argv[1:], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
seconds = time.monotonic() - began
usage = resource.getrusage(resource.RUSAGE_CHILDREN)
words = done.stderr.decode(errors="replace").strip().splitlines()
print(json.dumps([done.returncode, words[-1:], seconds, usage.ru_utime + usage.ru_stime, usage.ru_maxrss]))
"""


def _measure(command: list[str]) -> Cost:
    """Run a command line and return what it took."""
    done = subprocess.run(
        [sys.executable, "-c", _LAUNCHER, *command], stdout=subprocess.PIPE, check=True
    )
    code, words, seconds, processor, kib = json.loads(done.stdout)
    if code != 0:
        raise EndocalError(f"{command[0]} failed: {words[0] if words else f'exit {code}'}")
    return Cost(seconds, processor, kib / 1024)


def _make_clip(path: Path, size: tuple[int, int], frames: int) -> Path:
    """Write a clip that encodes easily: a soft texture that drifts, and a tone."""
    samples: Any = np.arange(int(_SOUND_RATE * frames / 25), dtype=np.float32)
    tone: Any = np.float32(0.2) * np.sin(np.float32(0.06) * samples)
    pictures = _drift(size, frames)
    compose(str(path), pictures, size, Fraction(25), sound=tone, sound_rate=_SOUND_RATE)
    return path


def _drift(size: tuple[int, int], frames: int) -> Iterator[np.ndarray]:
    w, h = size
    rng = np.random.default_rng(1)
    coarse = rng.uniform(40, 200, (h // 24 + 2, (w + 256) // 24 + 2, 3)).astype(np.float32)
    scene: Any = cv2.resize(coarse, (w + 256, h), interpolation=cv2.INTER_CUBIC)
    scene += rng.normal(0, 2, scene.shape).astype(np.float32)
    whole = scene.clip(0, 255).astype(np.uint8)
    for number in range(frames):
        shift = abs((number + 128) % 512 - 256)
        yield np.ascontiguousarray(whole[:, shift : shift + w])


def _row(name: str, costs: list[Cost]) -> Row:
    middle = Cost(
        median(c.seconds for c in costs),
        median(c.processor for c in costs),
        max(c.memory for c in costs),
    )
    return Row(name, middle, min(c.seconds for c in costs))


def _added(costs: dict[str, list[Cost]], what: str) -> float | None:
    if LENS not in costs:
        return None
    rounds = zip(costs[PLAIN], costs[LENS], costs[OURS], strict=True)
    values = ([getattr(cost, what) for cost in each] for each in rounds)
    ratios = [(ours - plain) / (lens - plain) for plain, lens, ours in values if lens != plain]
    return median(ratios) if ratios else None


def _ratio(costs: dict[str, list[Cost]]) -> float | None:
    if PLAIN not in costs:
        return None
    pairs = zip(costs[PLAIN], costs[OURS], strict=True)
    return median(ours.seconds / plain.seconds for plain, ours in pairs)
