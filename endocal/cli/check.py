"""``endocal check``: a recorded calibration, made again and compared."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..errors import CalibrationError
from .options import Json, note, print_json

EXAMPLES = ("endocal check cal.toml", "endocal check cal.toml --images pictures/ --tolerance 0.5")


def command(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="A calibration, which names its pictures.")
    ],
    images: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Look for the pictures in this folder and those below; by default beside FILE.",
            show_default=False,
        ),
    ] = None,
    tolerance: Annotated[
        float,
        typer.Option(
            metavar="T",
            help="How far a number may move, in standard deviations: the smaller of stated and found.",
        ),
    ] = 0.1,
    json: Json = False,
) -> None:
    """Calibrate again from the recorded pictures, with the recorded options; exit 1 if a number moved.

    The pictures are found by name and proved by their SHA-256. lambda, lambda2 and the centre are
    compared. Where FILE states no standard deviations, 1 % of lambda and 1 px of the centre stand in.
    """
    from ..files.names import shown
    from ..jobs.check import CheckSpec, check

    report = check(CheckSpec(str(file), None if images is None else str(images), tolerance))
    if json:
        print_json(report.data())
    else:
        for n in report.numbers:
            typer.echo(
                f"{n.name:<9}{n.recorded:>16.9g} recorded {n.found:>16.9g} found"
                f"   moved by {n.moved:.2g}, {n.allowed:.2g} {n.unit} allowed"
            )
    if report.recorded_verdict not in (None, report.found_verdict):
        note(f"the verdict was {report.recorded_verdict} and is {report.found_verdict} now")
    if report.failures:
        raise CalibrationError(f"{shown(file)}: {'; '.join(report.failures)}")
