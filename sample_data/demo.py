"""Run the whole job on the samples and compare with the truth: ``python sample_data/demo.py FOLDER``.

Calibrates the four boards, makes the zoom table, corrects the clip, and leaves everything in FOLDER, with
pictures of before and after and a page of each result. Exits 1 where an error against the truth is above what
is promised.
"""

from __future__ import annotations

import csv
import shlex
import statistics
import subprocess
import sys
from pathlib import Path

from endocal import Calibration, DivisionModel, load

SAMPLES = Path(__file__).resolve().parent
CLIP = SAMPLES / "clip.mp4"
BOARDS = sorted(SAMPLES.glob("board-*.png"))

# What is promised: for each setting, and for the frames of the clip.
MAX_LAMBDA_ERROR = 0.005
MAX_CENTER_ERROR = 0.5  # px
MAX_FRAME_LAMBDA_ERROR = 0.03
MAX_MEDIAN_FRAME_LAMBDA_ERROR = 0.01


def main() -> None:
    """Run the demo."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "demo")
    folder.mkdir(parents=True, exist_ok=True)
    settings = [folder / f"{board.stem}.toml" for board in BOARDS]
    for board, setting in zip(BOARDS, settings, strict=True):
        endocal("calibrate", board, "-o", setting, "--report", setting.with_suffix(".html"))
    table, clip, log = folder / "zoom.toml", folder / "corrected.mp4", folder / "zoom-log.csv"
    endocal("zoomtable", *settings, "-o", table, "--report", table.with_suffix(".html"))
    lens = ("-c", table)
    run = folder / "run.html"
    endocal("correct", CLIP, "-o", clip, *lens, "--zoom-log", log, "--report", run)
    picture = folder / "before-after.png"
    endocal("correct", CLIP, "-o", picture, *lens, "--preview", "2s")
    beside = folder / "side-by-side.mp4"
    endocal("correct", CLIP, "-o", beside, *lens, "--side-by-side")

    good = compare_settings(settings)
    good = compare_frames(log) and good
    print("\nLook at:")
    for path in (picture, beside, clip, table):
        print(f"  {path}")
    print("\nOpen in a browser:")
    for path in (*(s.with_suffix(".html") for s in settings), table.with_suffix(".html"), run):
        print(f"  {path.resolve().as_uri()}")
    if not good:
        sys.exit("demo: an error is above what is promised")


def endocal(*arguments: str | Path) -> None:
    """Show a command line, and run it with --overwrite, so that the demo can be repeated."""
    words = [str(a) for a in arguments]
    print(f"\n$ endocal {shlex.join(words)}", flush=True)
    done = subprocess.run([sys.executable, "-m", "endocal", *words, "--overwrite"], check=False)
    if done.returncode:
        sys.exit(f"demo: endocal {words[0]} failed")


def compare_settings(settings: list[Path]) -> bool:
    """Print each setting's errors against the truth; say whether all are small enough."""
    print(f"\n{'setting':<12}{'lambda px^-2':>14}{'truth':>14}{'error':>9}   centre error px")
    good = True
    for board, setting in zip(BOARDS, settings, strict=True):
        found, truth = model_of(setting), model_of(board.with_suffix(".truth.toml"))
        error = found.lam / truth.lam - 1
        dx, dy = (a - b for a, b in zip(found.center, truth.center, strict=True))
        off = (dx**2 + dy**2) ** 0.5
        print(
            f"{board.stem:<12}{found.lam:>14.5e}{truth.lam:>14.5e}{error:>+9.3%}"
            f"   {off:.3f}  ({dx:+.3f}, {dy:+.3f})"
        )
        good &= abs(error) <= MAX_LAMBDA_ERROR and off <= MAX_CENTER_ERROR
    return good


def model_of(path: Path) -> DivisionModel:
    """Return the model in a calibration file."""
    calibration = load(path)
    assert isinstance(calibration, Calibration)
    return calibration.model


def compare_frames(log: Path) -> bool:
    """Print how far lambda was off over the clip's frames; say whether that is small enough."""
    truth = rows_of(SAMPLES / "clip.truth.csv")
    found = rows_of(log)
    errors = [
        abs(float(f["lambda"]) / float(t["lambda"]) - 1) for f, t in zip(found, truth, strict=True)
    ]
    sources = [row["source"] for row in found]
    counts = ", ".join(f"{sources.count(s)} by {s}" for s in dict.fromkeys(sources))
    worst = max(range(len(errors)), key=errors.__getitem__)
    median = statistics.median(errors)
    print(
        f"\nclip: {len(errors)} frames ({counts}); lambda error: median {median:.2%},"
        f" worst {errors[worst]:.2%} at frame {worst}"
    )
    return errors[worst] <= MAX_FRAME_LAMBDA_ERROR and median <= MAX_MEDIAN_FRAME_LAMBDA_ERROR


def rows_of(path: Path) -> list[dict[str, str]]:
    """Return the rows of a CSV file."""
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


if __name__ == "__main__":
    main()
