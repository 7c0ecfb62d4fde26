"""``endocal export``: a lens for other tools."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Annotated

import typer

from ..errors import UsageError
from .options import VIEWS, Config, Json, Output, Overwrite, choices, note, parse_size, print_json

if TYPE_CHECKING:
    from ..jobs.export import ExportReport

EXAMPLES = (
    "endocal export -c cal.toml --to opencv -o cal.yaml --rational",
    "endocal export -c zoom.toml --diameter 600 --to ros -o camera_info.yaml",
    "endocal export -c cal.toml --to ffmpeg -o lens.pgm",
)

To = Annotated[
    str,
    typer.Option(
        metavar="KIND",
        autocompletion=choices("opencv", "ros", "gyroflow", "ffmpeg", "stmap", "npz"),
        help="opencv, ros or gyroflow: a model; ffmpeg, stmap, npz: maps.",
    ),
]
Diameter = Annotated[
    float | None, typer.Option(metavar="D", help="Zoom table: the visible circle's diameter, px.")
]
SettingNumber = Annotated[
    int | None,
    typer.Option("--setting", metavar="N", help="Zoom table: the setting's number, from 1."),
]
Frame = Annotated[
    str | None,
    typer.Option(metavar="WxH", help="Size of the frames, px; else the calibration's."),
]
Rational = Annotated[
    bool, typer.Option("--rational", help="Eight coefficients instead of five: far nearer.")
]
Focal = Annotated[
    float | None,
    typer.Option(metavar="F", help="Focal length, px, where known; correcting does not need it."),
]
Name = Annotated[
    str | None, typer.Option(metavar="NAME", help="The camera's name, for ros, gyroflow.")
]
View = Annotated[
    str,
    typer.Option(
        metavar="NAME", autocompletion=VIEWS, help="Maps: same, crop or full, as for correct."
    ),
]
Size = Annotated[str | None, typer.Option(metavar="WxH", help="Maps: size of the output, px.")]
Scale = Annotated[
    float | None, typer.Option(metavar="S", help="Maps: magnification of the output.")
]
Depth = Annotated[
    int | None,
    typer.Option(
        metavar="BITS",
        autocompletion=choices("16", "32"),
        help="stmap: 32 (floats, the default) or 16.",
    ),
]


def command(
    config: Config,
    to: To,
    output: Output,
    diameter: Diameter = None,
    setting: SettingNumber = None,
    frame: Frame = None,
    rational: Rational = False,
    focal: Focal = None,
    name: Name = None,
    view: View = "same",
    size: Size = None,
    scale: Scale = None,
    depth: Depth = None,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Write a lens for another tool: OpenCV, ROS, ffmpeg, Nuke and the like (STMap), Gyroflow, NumPy.

    A model is fitted over the visible content and its largest error told; maps are exact.
    """
    from ..jobs.export import ExportSpec, export

    if json and str(output) == "-":
        raise UsageError("--json and -o - both write to stdout: name an output file")
    report = export(
        ExportSpec(
            calibration=str(config),
            output=str(output),
            to=to,
            diameter=diameter,
            setting=setting,
            frame=parse_size(frame),
            rational=rational,
            focal=focal,
            name=name,
            view=view,
            size=parse_size(size),
            scale=scale,
            depth=depth,
            overwrite=overwrite,
        )
    )
    if json:
        print_json(dataclasses.asdict(report))
    _tell(report, json)


def _tell(report: ExportReport, quiet: bool) -> None:
    """Say on standard error how good the export is, and print ffmpeg's command line on standard output."""
    for text in report.notes:
        note(f"note: {text}")
    error = ""
    if report.largest_error is not None:
        error = (
            f": at most {report.largest_error:.2g} px off (rms {report.rms_error:.2g}) within"
            f" {report.radius:.0f} px of the centre"
        )
    note(f"{', '.join(report.files)}{error}")
    if report.command is not None and not quiet:
        typer.echo(report.command)
