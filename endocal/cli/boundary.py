"""``endocal boundary``: the visible circle of a video or a picture."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..errors import UsageError
from .options import Overwrite, note, print_json
from .progress import progress_bar

if TYPE_CHECKING:
    from ..jobs.boundary import BoundaryReport

EXAMPLES = (
    "endocal boundary surgery.mp4 | jq .boundary.diameter",
    "endocal boundary surgery.mp4 --overlay circle.mp4 > circle.jsonl",
)


def command(
    source: Annotated[
        str, typer.Argument(metavar="INPUT", help="A video or a picture; - is stdin.")
    ],
    overlay: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write the input with the circle drawn in here."),
    ] = None,
    pixel_aspect: Annotated[
        float | None,
        typer.Option(
            "--pixel-aspect",
            metavar="RATIO",
            help="A pixel's width over its height; else the video's.",
        ),
    ] = None,
    overwrite: Overwrite = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Say nothing on stderr.")] = False,
) -> None:
    """Print the visible circle, one JSON line per frame; its boundary is null where none is visible."""
    from ..jobs.boundary import BoundaryJob, find_boundaries

    if pixel_aspect is not None and not 0.1 <= pixel_aspect <= 10:
        raise UsageError(f"--pixel-aspect {pixel_aspect:g}: a ratio from 0.1 to 10 is needed")
    job = BoundaryJob(source, None if overlay is None else str(overlay), pixel_aspect, overwrite)
    with progress_bar(source, quiet) as progress:
        report = find_boundaries(job, lambda found: print_json(found.data()), progress)
    if not quiet:
        _tell(report)


def _tell(report: BoundaryReport) -> None:
    """Say on standard error how much was found, and what was wrong with the input."""
    for warning in report.warnings:
        note(f"warning: {report.input}: {warning}")
    text = f"circle in {report.found} of {report.frames} frames"
    if report.diameter is not None:
        text += (
            f", diameter {report.diameter:.1f} px ({report.narrowest:.1f} to {report.widest:.1f})"
        )
    note(text)
