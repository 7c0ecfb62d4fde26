"""``endocal calibrate``: a lens from one picture of a chessboard or of parallel lines."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..errors import CalibrationError, UsageError
from .options import (
    METHODS,
    MODELS,
    Center,
    ChosenLines,
    Json,
    Output,
    Overwrite,
    Roi,
    Samples,
    Sobel,
    StatedAspect,
    note,
    parse_center,
    parse_roi,
    print_json,
)
from .pages import Page, check_page

if TYPE_CHECKING:
    from ..calibration.result import Calibration

EXAMPLES = (
    "endocal calibrate board.png -o cal.toml",
    "endocal calibrate board.png -o cal.toml --report cal.html",
    "endocal calibrate board.png -o cal.toml --json | jq .model",
    "endocal calibrate board.png -o wang.toml --method wang --lines lines.txt --no-refine",
    "endocal calibrate board.png -o - | endocal correct in.mp4 -o out.mp4 -c -",
)


def command(
    images: Annotated[
        list[Path],
        typer.Argument(
            metavar="IMAGE",
            help="A picture of the pattern; several of one lens at one setting are calibrated jointly.",
            show_default=False,
        ),
    ],
    output: Output,
    method: Annotated[
        str,
        typer.Option(
            metavar="hewg|heplp|hewog|ht1d|cht|htrdc|wang|corners",
            autocompletion=METHODS,
            help="How the model is found: the article's methods; endocal compare sets them side by side.",
        ),
    ] = "hewg",
    model: Annotated[
        str,
        typer.Option(
            metavar="NAME", autocompletion=MODELS, help="division, or division2 (two parameters)."
        ),
    ] = "division",
    refine: Annotated[
        bool, typer.Option("--refine/--no-refine", help="Refine to sub-pixel after the search.")
    ] = True,
    center: Center = "free",
    samples: Samples = 10,
    sobel: Sobel = 21,
    roi: Roi = None,
    pixel_aspect: StatedAspect = None,
    lines: ChosenLines = None,
    page: Page = None,
    force: Annotated[
        bool, typer.Option("--force", help="Write the file even where the verdict is failed.")
    ] = False,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Calibrate a lens from one picture, with no clicks and no board size.

    Show the pattern large, sharp and tilted a little, so that its lines reach out to the rim. Writes the
    model, its uncertainty and a verdict: good, doubtful (with reasons) or failed (exit 1, no file).
    """
    from ..calibration.spec import CalibrationSpec
    from ..files import check_output, read_lines, save
    from ..files.names import shown
    from ..jobs.calibrate import report_files
    from ..jobs.show import as_data

    if json and str(output) == "-":
        raise UsageError("--json and -o - both write to stdout: name an output file")
    inputs = images if lines is None else [*images, lines]
    check_output(output, overwrite, inputs)
    if page is not None:
        check_page(page, output, overwrite, inputs, json)
    spec = CalibrationSpec(
        method=method,
        refine=refine,
        center=parse_center(center),
        samples=samples,
        sobel=sobel,
        roi=parse_roi(roi),
        model=model,
        pixel_aspect=pixel_aspect,
        lines=None if lines is None else read_lines(lines),
    )
    report = report_files(images, spec)
    calibration = report.calibration
    for path, reason in report.left_out:
        note(f"note: {shown(path)} left out: {reason}")
    for words in report.notes:
        note(f"note: {words}")
    if page is not None:
        from ..jobs.report import report_calibration

        # For a calibration that failed too: it shows why.
        name = output.name if str(output) != "-" else images[0].name
        report_calibration(report, name, str(page), overwrite)
    quality = calibration.quality
    if quality is not None and quality.verdict == "failed" and not force:
        names = ", ".join(shown(image) for image in images)
        first, *more = quality.reasons
        rest = f"; {len(more)} more in the file that --force writes" if more else ""
        rest = rest or "; --force writes it all the same"
        seen = "" if page is None else f"; {shown(page)} shows why"
        raise CalibrationError(f"{names}: {first}{rest}{seen}")
    save(calibration, output, overwrite=overwrite)
    _tell(calibration, shown(output))
    if page is not None:
        note(f"{shown(page)}: its page")
    if json:
        # Last: where standard output takes nothing, what stays has been told.
        print_json(as_data(calibration))


def _tell(calibration: Calibration, output: str) -> None:
    """Say on standard error what was found, and what the file that holds it is called."""
    model, u, quality = calibration.model, calibration.uncertainty, calibration.quality
    lam, x, y = model.lam, *model.center
    if u is None:
        note(f"lambda {lam:.4e} px^-2, centre {x:.1f}, {y:.1f} px")
    else:
        center = f"{x:.2f} ± {u.center[0]:.2f}, {y:.2f} ± {u.center[1]:.2f} px"
        if u.center_given:
            center = f"{x:.2f}, {y:.2f} px as given"
        note(f"lambda {lam:.5e} ± {u.lam:.1e} px^-2, centre {center}")
    if model.lam2 and u is not None and u.lam2 is not None:
        note(f"lambda2 {model.lam2:.5e} ± {u.lam2:.1e} px^-4")
    elif model.lam2:
        note(f"lambda2 {model.lam2:.4e} px^-4")
    if quality is not None:
        if quality.rms is not None:
            share = quality.outlying_told
            without = (
                f", without the {share:.0%} of points that do not follow them" if share else ""
            )
            note(
                f"{quality.lines} lines, {quality.points} points: straight to {quality.rms:.3f} px"
                f" ({quality.rms_before:.2f} px before){without}"
            )
        for reason in quality.reasons:
            note(f"{quality.verdict}: {reason}")
    note(f"{output}: {quality.verdict if quality else 'written'}")
