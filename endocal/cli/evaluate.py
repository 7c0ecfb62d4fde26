"""``endocal evaluate``: how straight a lens makes the lines of pictures."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..errors import UsageError
from .options import Board, ChosenLines, Config, Json, Roi, note, parse_board, parse_roi, print_json

if TYPE_CHECKING:
    from ..calibration.evaluate import Evaluation

EXAMPLES = (
    "endocal evaluate -c cal.toml board.png",
    "endocal evaluate -c cal.toml --board 11x8 board.png --json | jq .all.rmse",
    "endocal evaluate -c zoom.toml wide.png middle.png tele.png",
)


def command(
    images: Annotated[
        list[Path],
        typer.Argument(
            metavar="IMAGE", help="A picture of straight lines, or several.", show_default=False
        ),
    ],
    config: Config,
    lines: ChosenLines = None,
    board: Board = None,
    roi: Roi = None,
    json: Json = False,
) -> None:
    """Measure how straight a calibration makes the lines of pictures, before and after.

    RMSE is the article's: in px of the corrected picture, whose magnification counts. Straightness is in px
    of the picture as it is. The lines are those of --lines, or a chessboard's with --board, or found in the
    picture, whatever the calibration is.
    """
    from ..calibration.spec import CalibrationSpec
    from ..files import read_lines
    from ..files.names import shown
    from ..jobs.evaluate import EvaluationSpec, evaluate_files
    from ..jobs.line_source import LineSource

    if lines is not None and str(lines) == str(config) == "-":
        raise UsageError("--config and --lines both read stdin: name a file for one")
    source = LineSource(None if lines is None else read_lines(lines), parse_board(board))
    spec = EvaluationSpec(
        str(config), tuple(map(str, images)), source, CalibrationSpec(roi=parse_roi(roi))
    )
    report = evaluate_files(spec)
    for picture in report.pictures:
        for text in picture.notes:
            note(f"note: {shown(picture.image)}: {text}")
    if json:
        print_json(report.data())
        return
    typer.echo(f"{'':<24}{'lines':>6}{'points':>8}{'RMSE, px':>18}{'straightness, px':>22}")
    for picture in report.pictures:
        typer.echo(_row(shown(picture.image), picture.evaluation))
    if len(report.pictures) > 1:
        typer.echo(_row("all", report.total))


def _row(name: str, e: Evaluation) -> str:
    rmse, straightness = (
        f"{before:.3f} -> {after:.3f}" if math.isfinite(after) else f"{before:.3f} -> folded"
        for before, after in ((e.rmse_before, e.rmse), (e.straightness_before, e.straightness))
    )
    return f"{name:<24}{e.lines:>6}{e.points:>8}{rmse:>18}{straightness:>22}"
