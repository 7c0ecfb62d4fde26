"""``endocal show``: a calibration or zoom table for people."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .options import Json, print_json

EXAMPLES = ("endocal show cal.toml", "endocal show --json zoom.toml | jq .law")


def command(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="A calibration or zoom table; - is stdin.")
    ],
    json: Json = False,
) -> None:
    """Print what a calibration or a zoom table says."""
    from ..files import load
    from ..jobs.show import as_data, describe

    obj = load(file)
    if json:
        print_json(as_data(obj))
        return
    for label, text in describe(obj):
        typer.echo(f"{label:<14}{text}")
