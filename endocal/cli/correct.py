"""``endocal correct``: a video or a picture without its lens distortion."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..errors import UsageError
from .correction import Configs, Quiet, file_option, parse_configs, takes_correction
from .options import Json, Output, Overwrite, note, print_json
from .progress import progress_bar

if TYPE_CHECKING:
    from ..jobs.correction import CorrectionReport, CorrectionSpec, Progress

EXAMPLES = (
    "endocal correct surgery.mp4 -o corrected.mp4 -c zoom.toml",
    "endocal correct frame.png -o corrected.png -c cal.toml --view full",
    "endocal correct surgery.mp4 -o look.png -c zoom.toml --preview 1:30",
    "ffmpeg -i in.avi -f yuv4mpegpipe - | endocal correct - -o - -c zoom.toml | ffplay -",
)


@takes_correction
def command(
    source: Annotated[
        str, typer.Argument(metavar="INPUT", help="A video or a picture; - is stdin.")
    ],
    output: Output,
    config: Configs,
    fields: dict[str, Any],
    container: Annotated[
        str | None,
        file_option("--format", metavar="NAME", help="Container of a pipe: y4m, matroska, mpegts."),
    ] = None,
    zoom_log: Annotated[
        str | None,
        file_option(
            "--zoom-log", metavar="FILE", help="Write each frame's zoom here (.csv or .jsonl)."
        ),
    ] = None,
    zoom_from: Annotated[
        str | None,
        file_option("--zoom-from", metavar="FILE", help="Take each frame's zoom from such a file."),
    ] = None,
    live: Annotated[
        bool,
        file_option(
            "--live", help="INPUT is an address (rtsp://, udp://, …) or /dev/video0; never queue."
        ),
    ] = False,
    threads: Annotated[
        int, typer.Option(metavar="N", help="Threads to decode and to encode with; 0: by cores.")
    ] = 0,
    page: Annotated[
        str | None,
        file_option(
            "--report", metavar="FILE", help="Write a page for people: the zoom over time."
        ),
    ] = None,
    preview: Annotated[
        str | None,
        typer.Option(
            metavar="INSTANT",
            help="Write a picture of one frame (250) or time (12.5s, 1:02:03): before | after, with a grid.",
        ),
    ] = None,
    overwrite: Overwrite = False,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Correct the lens distortion of a video or a picture, and keep all else as it is."""
    from ..jobs.correct import correct
    from ..jobs.correction import CorrectionSpec
    from ..jobs.pipe import PIPE

    if json and str(output) == PIPE:
        raise UsageError("--json and -o - both write to stdout: name an output file")
    calibration, right_calibration = parse_configs(config)
    spec = CorrectionSpec(
        input=source,
        output=str(output),
        calibration=calibration,
        right_calibration=right_calibration,
        container_format=container,
        zoom_log=zoom_log,
        zoom_from=zoom_from,
        overwrite=overwrite,
        live=live,
        threads=threads,
        **fields,
    )
    if preview is not None:
        if page is not None:
            raise UsageError("--preview excludes --report")
        _preview(spec, preview, json, quiet)
        return
    with progress_bar(source, quiet) as progress:
        report = correct(spec, progress) if page is None else _with_page(spec, page, progress)
    if json:
        print_json(dataclasses.asdict(report))
    if quiet:
        return
    _tell(report)
    if page is not None:
        note(f"{page}: its page")


def _with_page(
    spec: CorrectionSpec, page: str, progress: Callable[[Progress], None] | None
) -> CorrectionReport:
    from ..jobs.report_run import correct_and_report

    return correct_and_report(spec, page, progress)


def _preview(spec: CorrectionSpec, instant: str, json: bool, quiet: bool) -> None:
    from ..jobs.instant import Instant
    from ..jobs.preview import preview

    report = preview(spec, Instant.parse(instant))
    if json:
        print_json(dataclasses.asdict(report))
    if quiet:
        return
    for text in report.notes:
        note(f"note: {text}")
    at = "" if report.time is None else f" at {report.time:.2f} s"
    note(f"{report.output}: before and after{at}, lambda {report.lam:.4e} px^-2")


def _tell(report: CorrectionReport) -> None:
    """Say on standard error what was done, and what was odd about it."""
    for text in report.notes:
        note(f"note: {text}")
    for text in report.warnings:
        note(f"warning: {report.input}: {text}")
    w, h = report.size_out
    if report.codec is None:
        note(f"{report.output}: picture of {w}x{h} on {report.device}")
        return
    if report.latency is not None:
        late = report.latency
        note(
            f"latency {late.median:.0f} ms, {late.most:.0f} ms at most;"
            f" {late.dropped} frames left out to keep up"
        )
    rate = report.frames / report.seconds if report.seconds else 0.0
    note(
        f"{report.output}: {report.frames} frames of {w}x{h}, {report.codec}, in {report.seconds:.1f} s"
        f" ({rate:.0f} fps) on {report.device}"
    )
