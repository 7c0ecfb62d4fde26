"""``endocal calibrate``: a lens from one picture of a chessboard or of parallel lines."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..errors import CalibrationError, UsageError
from .options import (
    METHODS,
    MODELS,
    Json,
    Output,
    Overwrite,
    choices,
    note,
    parse_numbers,
    print_json,
)

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
    center: Annotated[
        str,
        typer.Option(
            metavar="free|image|X,Y",
            autocompletion=choices("free", "image"),
            help="The distortion centre: sought or given.",
        ),
    ] = "free",
    samples: Annotated[int, typer.Option(metavar="S", help="Samples per axis of the search.")] = 10,
    sobel: Annotated[
        int, typer.Option(metavar="K", help="Size of the Sobel mask whose gradients vote, px, odd.")
    ] = 21,
    roi: Annotated[
        str | None,
        typer.Option(metavar="X,Y,W,H", help="Look at this part of the picture only, px."),
    ] = None,
    pixel_aspect: Annotated[
        float, typer.Option(metavar="A", help="A pixel's width over its height.")
    ] = 1.0,
    page: Annotated[
        Path | None,
        typer.Option(
            *("--report",),
            metavar="FILE",
            help="Write a page for people: the lines, what is left, how sure (.html).",
            show_default=False,
        ),
    ] = None,
    lines: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Lines that you chose, for the methods wang and htrdc: a point x y a row, in px, an empty"
            " row after each line; - is stdin.",
            show_default=False,
        ),
    ] = None,
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
    from ..jobs.calibrate import report_files
    from ..jobs.show import as_data

    if json and str(output) == "-":
        raise UsageError("--json and -o - both write to stdout: name an output file")
    check_output(output, overwrite, images)
    if page is not None:
        _check_page(page, output, json)
        check_output(page, overwrite, images)
    region = parse_numbers(roi, "--roi", 4)
    spec = CalibrationSpec(
        method=method,
        refine=refine,
        center=_center(center),
        samples=samples,
        sobel=sobel,
        roi=None
        if region is None
        else (int(region[0]), int(region[1]), int(region[2]), int(region[3])),
        model=model,
        pixel_aspect=pixel_aspect,
        lines=None if lines is None else read_lines(lines),
    )
    report = report_files(images, spec)
    calibration = report.calibration
    for path in report.left_out:
        note(f"note: {path} left out: it does not fit the lens of the other pictures")
    if page is not None:
        from ..jobs.report import report_calibration

        # For a calibration that failed too: it shows why.
        name = output.name if str(output) != "-" else images[0].name
        report_calibration(report, spec, name, str(page), overwrite)
    quality = calibration.quality
    if quality is not None and quality.verdict == "failed" and not force:
        names = ", ".join(str(image) for image in images)
        first, *more = quality.reasons
        rest = f"; {len(more)} more in the file that --force writes" if more else ""
        rest = rest or "; --force writes it all the same"
        seen = "" if page is None else f"; {page} shows why"
        raise CalibrationError(f"{names}: {first}{rest}{seen}")
    save(calibration, output, overwrite=overwrite)
    if json:
        print_json(as_data(calibration))
    _tell(calibration, output)
    if page is not None:
        note(f"{page}: its page")


def _check_page(page: Path, output: Path, json: bool) -> None:
    """Refuse a page that would share its place with another output, or that cannot be made at all."""
    from ..report.figures import require_figures

    if str(page) == "-" and (json or str(output) == "-"):
        raise UsageError("--report - shares stdout with another output: name a file")
    if str(page) != "-" and page.resolve() == output.resolve():
        raise UsageError(f"--report {page}: is the calibration's own file: give it another name")
    require_figures()


def _center(value: str) -> str | tuple[float, float]:
    if value in ("free", "image"):
        return value
    try:
        numbers = parse_numbers(value, "--center", 2)
    except UsageError:
        raise UsageError(f"--center {value!r}: write free, image or X,Y in pixels") from None
    return (numbers[0], numbers[1]) if numbers else "free"


def _tell(calibration: Calibration, output: Path) -> None:
    """Say on standard error what was found."""
    model, u, quality = calibration.model, calibration.uncertainty, calibration.quality
    lam, x, y = model.lam, *model.center
    if u is None:
        note(f"lambda {lam:.4e} px^-2, centre {x:.1f}, {y:.1f} px")
    else:
        note(
            f"lambda {lam:.5e} ± {u.lam:.1e} px^-2,"
            f" centre {x:.2f} ± {u.center[0]:.2f}, {y:.2f} ± {u.center[1]:.2f} px"
        )
    if model.lam2:
        note(f"lambda2 {model.lam2:.4e} px^-4")
    if quality is not None:
        if quality.rms is not None:
            note(
                f"{quality.lines} lines, {quality.points} points: straight to {quality.rms:.3f} px"
                f" ({quality.rms_before:.2f} px before)"
            )
        for reason in quality.reasons:
            note(f"{quality.verdict}: {reason}")
    note(f"{output}: {quality.verdict if quality else 'written'}")
