"""``endocal import``: a lens from OpenCV's or ROS's calibration."""

from __future__ import annotations

from typing import Annotated

import typer

from ..errors import UsageError
from .options import MODELS, Json, Output, Overwrite, note, parse_numbers, parse_size, print_json

EXAMPLES = (
    "endocal import camera_info.yaml -o cal.toml",
    "endocal import opencv.json -o cal.toml --size 1920x1080 --model division2",
)

File = Annotated[
    str,
    typer.Argument(metavar="FILE", help="OpenCV's YAML or JSON, ROS's camera_info; - is stdin."),
]
Model = Annotated[
    str,
    typer.Option(
        metavar="NAME", autocompletion=MODELS, help="division, or division2 (two parameters)."
    ),
]
Size = Annotated[
    str | None,
    typer.Option(metavar="WxH", help="Size of the frames, px, where the file tells none."),
]
Circle = Annotated[
    str | None, typer.Option(metavar="X,Y,D", help="Centre and diameter of the visible circle, px.")
]


def command(
    file: File,
    output: Output,
    model: Model = "division",
    size: Size = None,
    circle: Circle = None,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Read a lens from OpenCV or ROS: the division model that corrects most alike, and its error."""
    from ..jobs.import_lens import ImportSpec, import_lens
    from ..jobs.show import as_data

    if json and str(output) == "-":
        raise UsageError("--json and -o - both write to stdout: name an output file")
    numbers = parse_numbers(circle, "--circle", 3)
    report = import_lens(
        ImportSpec(
            input=file,
            output=str(output),
            model=model,
            size=parse_size(size),
            circle=(numbers[0], numbers[1], numbers[2]) if numbers else None,
            overwrite=overwrite,
        )
    )
    if json:
        fit = {"largest_error": report.largest_error, "rms_error": report.rms_error}
        print_json({**as_data(report.calibration), **fit, "notes": report.notes})
    for text in report.notes:
        note(f"note: {text}")
    lens = report.calibration.model
    x, y = lens.center
    note(
        f"{output}: lambda {lens.lam:.6g} px^-2, centre {x:.2f}, {y:.2f} px: at most"
        f" {report.largest_error:.2g} px (rms {report.rms_error:.2g}) from {file}"
    )
