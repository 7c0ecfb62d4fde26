"""``endocal zoomtable``: the settings of a zoom lens in one table."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..errors import UsageError
from .options import METHODS, MODELS, Json, Output, Overwrite, StatedAspect, note, print_json
from .pages import Page, check_page

if TYPE_CHECKING:
    from ..jobs.zoomtable import ZoomTableReport

EXAMPLES = (
    "endocal zoomtable wide.png middle.png tele.png -o zoom.toml",
    "endocal zoomtable wide.png middle.png tele.png -o zoom.toml --report zoom.html",
    "endocal zoomtable wide.toml tele.toml -o zoom.toml --json | jq .law",
)


def command(
    items: Annotated[
        list[Path],
        typer.Argument(
            metavar="ITEM",
            help="A pattern image at one zoom setting, or a calibration of one; 2 or more.",
            show_default=False,
        ),
    ],
    output: Output,
    method: Annotated[
        str,
        typer.Option(
            metavar="NAME",
            autocompletion=METHODS,
            help="How images are calibrated; see endocal calibrate.",
        ),
    ] = "hewg",
    model: Annotated[
        str,
        typer.Option(
            metavar="NAME", autocompletion=MODELS, help="division or division2 (two parameters)."
        ),
    ] = "division",
    pixel_aspect: StatedAspect = None,
    page: Page = None,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Tabulate a lens over its zoom: calibrate 2 or more settings (3 or 4 are typical), check the law.

    The visible circle tells the zoom, so each image must show its rim. When the zoom magnifies the picture
    by r, lambda falls by r squared: lambda * diameter^2 is one constant, and each setting's departure from
    it is printed.
    """
    from ..calibration.spec import CalibrationSpec
    from ..jobs.show import as_data
    from ..jobs.zoomtable import ZoomTableSpec, make_zoomtable

    if json and str(output) == "-":
        raise UsageError("--json and -o - both write to stdout: name an output file")
    if page is not None:
        check_page(page, output, overwrite, items, json)
    spec = ZoomTableSpec(
        tuple(str(item) for item in items),
        str(output),
        CalibrationSpec(method=method, model=model, pixel_aspect=pixel_aspect),
        overwrite,
    )
    report = make_zoomtable(spec, lambda item: note(f"reading {item}"))
    if json:
        data = as_data(report.table)
        data["law"]["departures"] = [round(d, 6) for d in report.table.law.departures]
        data["notes"] = list(report.notes)
        print_json(data)
    _tell(report)
    if page is not None:
        from ..jobs.report import report_table

        name = output.name if str(output) != "-" else "zoom table"
        report_table(report.table, name, str(page), overwrite)
        note(f"{page}: its page")


def _tell(report: ZoomTableReport) -> None:
    """Say on standard error what the table holds."""
    table, law = report.table, report.table.law
    for setting, departure in zip(table.settings, law.departures, strict=True):
        x, y = setting.center
        note(
            f"diameter {setting.diameter:8.2f} px  lambda {setting.lam:+.4e}  centre {x:.1f}, {y:.1f}"
            f"  {departure:+.2%} from the law"
        )
    note(f"law: lambda * diameter^2 = {law.lambda_diameter2:.4f}, spread {law.spread:.2%}")
    for text in report.notes:
        note(f"note: {text}")
    note(f"{report.output}: {len(table.settings)} settings")
