"""``endocal compare``: the methods side by side."""

from __future__ import annotations

import csv
import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..errors import UsageError
from .options import (
    Board,
    Center,
    ChosenLines,
    Json,
    PixelAspect,
    Roi,
    Samples,
    Sobel,
    note,
    parse_board,
    parse_center,
    parse_roi,
    print_json,
)

if TYPE_CHECKING:
    from ..jobs.compare import ComparisonReport, Picture, Row

EXAMPLES = (
    "endocal compare board.png",
    "endocal compare board-*.png --method hewg,heplp,wang --csv > methods.csv",
    "endocal compare board.png --board 11x8 --json | jq '.rows[] | {method, straightness}'",
)


def command(
    images: Annotated[
        list[Path],
        typer.Argument(
            metavar="IMAGE", help="A picture of the pattern, or several.", show_default=False
        ),
    ],
    method: Annotated[
        str | None,
        typer.Option(metavar="NAME,...", help="These methods only; all by default, and refined."),
    ] = None,
    refine: Annotated[
        bool, typer.Option("--refine", help="Refine each method's answer; bare by default.")
    ] = False,
    lines: ChosenLines = None,
    board: Board = None,
    center: Center = "free",
    samples: Samples = 10,
    sobel: Sobel = 21,
    roi: Roi = None,
    pixel_aspect: PixelAspect = 1.0,
    as_csv: Annotated[bool, typer.Option("--csv", help="Print the rows as CSV.")] = False,
    json: Json = False,
) -> None:
    """Calibrate by each method, bare, and set side by side what they find and how straight that is.

    All are measured on the same lines: those of --lines, or a chessboard's with --board, or found in the
    picture. RMSE is the article's, in px of the corrected picture; straightness is in px of the picture as it
    is. "refined" is hewg with its refinement, what endocal calibrate does.
    """
    from ..calibration.spec import CalibrationSpec
    from ..files import read_lines
    from ..jobs.compare import ComparisonSpec, compare
    from ..jobs.line_source import LineSource

    if as_csv and json:
        raise UsageError("--csv and --json both say how to print: give one")
    seen = CalibrationSpec(
        center=parse_center(center),
        samples=samples,
        sobel=sobel,
        roi=parse_roi(roi),
        pixel_aspect=pixel_aspect,
    )
    source = LineSource(None if lines is None else read_lines(lines), parse_board(board))
    spec = ComparisonSpec(tuple(map(str, images)), refine=refine, lines=source, seen=seen)
    if method is not None:
        spec = ComparisonSpec(spec.images, tuple(method.split(",")), refine, source, seen)
    report = compare(spec, progress=_tell if sys.stderr.isatty() else lambda work: None)
    if json:
        print_json(report.data())
    elif as_csv:
        _print_csv(report)
    else:
        for picture in report.pictures:
            _print_table(picture, [row for row in report.rows if row.image == picture.image])


def _tell(work: str) -> None:
    note(f"{work} ...")


def _print_csv(report: ComparisonReport) -> None:
    rows = [row.data() for row in report.rows]
    writer = csv.DictWriter(sys.stdout, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)


def _print_table(picture: Picture, rows: list[Row]) -> None:
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    title = f"{picture.image}: no lines to measure on: {picture.without}"
    if picture.without is None:
        title = (
            f"{picture.image}: {picture.lines} lines, RMSE {picture.rmse:.3f} px and straightness"
            f" {picture.straightness:.3f} px as it is"
        )
    table = Table()
    table.add_column("method", no_wrap=True)
    for head in ("lambda, px^-2", "centre, px", "RMSE, px", "straightness, px", "seconds"):
        table.add_column(head, justify="right", no_wrap=True)
    refusals = []
    for row in rows:
        if row.model is None:
            table.add_row(row.method, "refused", "", "", "", f"{row.seconds:.2f}")
            refusals.append(f"{row.method}: {row.refused}")
            continue
        x, y = row.model.center
        e = row.evaluation
        measures = ["", ""] if e is None else [_px(e.rmse), _px(e.straightness)]
        cells = [f"{row.model.lam:.4e}", f"{x:.1f}, {y:.1f}", *measures]
        table.add_row(row.method, *cells, f"{row.seconds:.2f}")
    # A pipe has no width of its own: the table takes what it needs.
    console = Console(file=sys.stdout, width=None if sys.stdout.isatty() else 120)
    console.print(escape(title), soft_wrap=True)
    console.print(table)
    for refusal in refusals:
        console.print(escape(refusal), soft_wrap=True)


def _px(value: float) -> str:
    return f"{value:.3f}" if math.isfinite(value) else "folded"
