"""Options that several commands share, each written once, and the parsing of their values."""

from __future__ import annotations

import contextlib
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

from ..errors import UsageError


def choices(*names: str) -> Callable[[str], list[str]]:
    """Return what completes an option's value from these names, for the shell."""
    return lambda incomplete: [name for name in names if name.startswith(incomplete)]


METHODS = choices("hewg", "heplp", "hewog", "ht1d", "cht", "htrdc", "wang", "corners")
MODELS = choices("division", "division2")
VIEWS = choices("same", "crop", "full")

Config = Annotated[
    Path,
    typer.Option("--config", "-c", metavar="FILE", help="A calibration or zoom table; - is stdin."),
]
Output = Annotated[
    Path, typer.Option("--output", "-o", metavar="FILE", help="Where to write; - is stdout.")
]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace an output that exists.")]
Json = Annotated[bool, typer.Option("--json", help="Print the result as JSON on stdout.")]
Device = Annotated[
    str,
    typer.Option(
        metavar="NAME",
        autocompletion=choices("auto", "numpy"),
        help="auto, numpy, part of an OpenCL device's name, or PLATFORM:DEVICE; see endocal devices.",
    ),
]
Center = Annotated[
    str,
    typer.Option(
        metavar="free|image|X,Y",
        autocompletion=choices("free", "image"),
        help="The distortion centre: sought or given.",
    ),
]
Samples = Annotated[int, typer.Option(metavar="S", help="Samples per axis of the search.")]
Sobel = Annotated[
    int,
    typer.Option(
        metavar="K",
        help="Px around an edge that tell its direction, the article's Sobel size; odd.",
    ),
]
Roi = Annotated[
    str | None,
    typer.Option(metavar="X,Y,W,H", help="Look at this part of the picture only, px."),
]
PixelAspect = Annotated[float, typer.Option(metavar="A", help="A pixel's width over its height.")]
StatedAspect = Annotated[
    float | None,
    typer.Option(
        metavar="A",
        help="A pixel's width over its height; else what the picture's file says, where that fits, or 1.",
        show_default=False,
    ),
]
ChosenLines = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        help="Lines that you chose: a point x y a row, in px, an empty row after each line; - is stdin.",
        show_default=False,
    ),
]
Board = Annotated[
    str | None,
    typer.Option(
        metavar="COLSxROWS", help="Measure on the inner corners of a chessboard that has so many."
    ),
]


def parse_center(value: str) -> str | tuple[float, float]:
    """Return a distortion centre's option as CalibrationSpec takes it; UsageError for anything else."""
    if value in ("free", "image"):
        return value
    try:
        numbers = parse_numbers(value, "--center", 2)
    except UsageError:
        raise UsageError(f"--center {value!r}: write free, image or X,Y in pixels") from None
    return (numbers[0], numbers[1]) if numbers else "free"


def parse_roi(value: str | None) -> tuple[int, int, int, int] | None:
    """Turn ``X,Y,W,H`` into whole px; UsageError for anything else."""
    numbers = parse_numbers(value, "--roi", 4)
    if numbers is None:
        return None
    return int(numbers[0]), int(numbers[1]), int(numbers[2]), int(numbers[3])


def parse_board(value: str | None) -> tuple[int, int] | None:
    """Turn ``11x8`` inner corners into (11, 8); UsageError for anything else."""
    try:
        return parse_size(value)
    except UsageError:
        raise UsageError(
            f"--board {value!r}: write COLUMNSxROWS of inner corners, such as 11x8"
        ) from None


def parse_size(value: str | None) -> tuple[int, int] | None:
    """Turn ``1920x1080`` into (1920, 1080); UsageError for anything else."""
    if value is None:
        return None
    width, _, height = value.lower().partition("x")
    if not (width.isdecimal() and height.isdecimal() and int(width) and int(height)):
        raise UsageError(f"{value!r} is no size: write WIDTHxHEIGHT in pixels, such as 1920x1080")
    return int(width), int(height)


def parse_numbers(value: str | None, option: str, count: int) -> tuple[float, ...] | None:
    """Turn ``X,Y`` (``count`` numbers) into floats; UsageError, naming the option, for anything else."""
    if value is None:
        return None
    parts = value.split(",")
    try:
        numbers = tuple(float(part) for part in parts)
    except ValueError:
        numbers = ()
    if len(numbers) != count or not all(abs(v) < float("inf") for v in numbers):
        raise UsageError(f"{option} {value!r}: give {count} numbers with commas between them")
    return numbers


def print_json(value: Any) -> None:
    """Print one JSON object on one line of stdout, at once."""
    sys.stdout.write(json.dumps(value, ensure_ascii=False, allow_nan=False) + "\n")
    sys.stdout.flush()


def note(message: str) -> None:
    """Print a note for the user on stderr; one that cannot be told does not undo what has been done."""
    with contextlib.suppress(OSError):
        print(f"endocal: {message}", file=sys.stderr)
