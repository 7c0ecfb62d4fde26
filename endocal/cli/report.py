"""``endocal report``: a page that shows a calibration, a zoom table or a zoom log."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .options import Overwrite, note

EXAMPLES = (
    "endocal report cal.toml -o cal.html",
    "endocal report cal.toml --images pictures/",
    "endocal report zoom-log.csv -o run.html",
)


def command(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help="A calibration, a zoom table (- is stdin), or a zoom log (.csv, .jsonl).",
        ),
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            *("--output", "-o"),
            metavar="FILE",
            help="The page; by default beside FILE, with .html; - is stdout.",
            show_default=False,
        ),
    ] = None,
    images: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Look for a calibration's pictures in this folder and those below; else beside FILE.",
            show_default=False,
        ),
    ] = None,
    overwrite: Overwrite = False,
) -> None:
    """Show a calibration, a zoom table or a zoom log as one HTML page, for people.

    A calibration is made again from its pictures, so that the page can show its lines, its residuals and
    how sure it is; without them it shows the numbers alone. The page loads nothing from a network.
    """
    from ..jobs.report import ReportSpec, report

    done = report(
        ReportSpec(
            str(file),
            None if output is None else str(output),
            None if images is None else str(images),
            overwrite,
        )
    )
    for text in done.notes:
        note(f"note: {text}")
    if done.output != "-":
        note(f"{done.output}: page of {file}")
