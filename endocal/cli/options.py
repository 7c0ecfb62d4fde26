"""Options that several commands share, each written once, and the parsing of their values."""

from __future__ import annotations

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
    """Print a note for the user on stderr."""
    print(f"endocal: {message}", file=sys.stderr)
