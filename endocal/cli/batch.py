"""``endocal batch``: many recordings, each once."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..errors import EndocalError
from .correction import Quiet, file_option, parse_configs, takes_correction
from .options import Json, note, print_json

if TYPE_CHECKING:
    from ..batch.plan import Plan

EXAMPLES = (
    "endocal batch recordings/ --recursive --out corrected/ -c zoom.toml",
    "endocal batch 'raw/**/*.mp4' --out corrected/ -c zoom.toml --jobs 4 --zoom-log .csv",
    "endocal batch scopes.toml --out corrected/ --dry-run",
    "endocal batch scopes.toml --out corrected/ --scheduler tcp://10.0.0.5:8786",
)


def _which(*names: str, help: str, metavar: str | None = None) -> Any:
    return typer.Option(*names, help=help, metavar=metavar, rich_help_panel="Which recordings")


def _how(*names: str, help: str, metavar: str | None = None) -> Any:
    return typer.Option(*names, help=help, metavar=metavar, rich_help_panel="How it runs")


@takes_correction
def command(
    sources: Annotated[
        list[str],
        typer.Argument(
            metavar="SOURCE...",
            help="Files, patterns, directories, or manifests (.toml, .csv).",
            show_default=False,
        ),
    ],
    out: Annotated[
        Path, typer.Option("--out", metavar="DIR", help="Where the outputs go, in the same tree.")
    ],
    fields: dict[str, Any],
    config: Annotated[
        list[Path] | None,
        typer.Option(
            *("--config", "-c"),
            metavar="FILE",
            help="A calibration or zoom table, for what no manifest gives another. Twice for two eyes.",
        ),
    ] = None,
    recursive: Annotated[
        bool, _which("--recursive", "-r", help="Go into the directories below.")
    ] = False,
    include: Annotated[
        list[str] | None,
        _which(
            "--include", metavar="PATTERN", help="From directories take these only; repeatable."
        ),
    ] = None,
    exclude: Annotated[
        list[str] | None,
        _which(
            "--exclude", metavar="PATTERN", help="From directories leave these out; repeatable."
        ),
    ] = None,
    root: Annotated[
        Path | None,
        _which("--root", metavar="DIR", help="The tree begins here, not at each source."),
    ] = None,
    retry_failed: Annotated[
        bool, _which("--retry-failed", help="Do only what failed before.")
    ] = False,
    redo: Annotated[bool, _which("--redo", help="Do again what is done, too.")] = False,
    rehash: Annotated[
        bool,
        _which("--rehash", help="Compare every input's and output's SHA-256; trust no timestamp."),
    ] = False,
    overwrite: Annotated[
        bool, _which("--overwrite", help="Replace outputs that are not of this batch.")
    ] = False,
    dry_run: Annotated[
        bool, _how("--dry-run", help="Print what would be done, and why; touch nothing.")
    ] = False,
    jobs: Annotated[
        int | None,
        _how(
            "--jobs", "-j", metavar="N", help="Recordings at once; by default by cores and memory."
        ),
    ] = None,
    threads: Annotated[
        int | None,
        _how("--threads", metavar="N", help="Threads of each; by default its share of the cores."),
    ] = None,
    scheduler: Annotated[
        str | None,
        _how(
            "--scheduler",
            metavar="ADDRESS",
            help="Run on the workers of this Dask scheduler; also a scheduler file (.json).",
        ),
    ] = None,
    retries: Annotated[
        int,
        _how(
            "--retries", metavar="N", help="Tries after a lost worker or a failing network drive."
        ),
    ] = 2,
    patience: Annotated[
        float,
        _how(
            "--patience", metavar="MINUTES", help="Give up a recording that stands still so long."
        ),
    ] = 60.0,
    keep_going: Annotated[
        bool,
        _how("--keep-going/--fail-fast", help="After a failure: go on, or begin nothing more."),
    ] = True,
    state: Annotated[
        Path | None,
        _how("--state", metavar="DIR", help="Where ledger and lock are; by default in --out."),
    ] = None,
    suffix: Annotated[
        str | None,
        file_option("--suffix", metavar=".EXT", help="Of the output videos; else the source's."),
    ] = None,
    zoom_log: Annotated[
        str | None,
        file_option("--zoom-log", metavar=".EXT", help="Write each zoom beside the output: .csv."),
    ] = None,
    zoom_from: Annotated[
        str | None,
        file_option(
            "--zoom-from", metavar=".EXT", help="Take each zoom from such a file beside it."
        ),
    ] = None,
    page: Annotated[
        str | None,
        file_option(
            "--report", metavar=".EXT", help="Write a page for each beside the output: .html."
        ),
    ] = None,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Correct many recordings: a tree of them, or what a manifest names, on all cores or a cluster.

    A ledger in the directory of outputs records what each was made from: run the same command again, after
    an interrupt, a power cut or new recordings, and it does what is missing, changed or failed. At the end
    batch-report.json and batch-report.html tell of each recording. Exits 1 where one failed.
    """
    from ..batch.recording import BatchSpec
    from ..batch.run import preview_batch, run_batch
    from .batch_view import batch_view, missing, summary, terminated

    calibration, right_calibration = parse_configs(config) if config else (None, None)
    spec = BatchSpec(
        sources=tuple(sources),
        out=str(out),
        calibration=calibration,
        right_calibration=right_calibration,
        correction=fields,
        recursive=recursive,
        root=None if root is None else str(root),
        include=tuple(include or ()),
        exclude=tuple(exclude or ()),
        suffix=suffix,
        zoom_log=zoom_log,
        zoom_from=zoom_from,
        report=page,
        state=None if state is None else str(state),
        jobs=jobs,
        threads=threads,
        scheduler=scheduler,
        retries=retries,
        patience_s=60 * patience,
        overwrite=overwrite,
        redo=redo,
        rehash=rehash,
        retry_failed=retry_failed,
        fail_fast=not keep_going,
    )
    if dry_run:
        plan = preview_batch(spec)
        _print_plan(plan, json, quiet)
        if plan.missing:
            raise EndocalError(missing(plan))
        return
    with batch_view(quiet) as view:
        report = run_batch(spec, view)
        view.ended(report)
    if json:
        print_json(report.data())
    if report.exit_code is not None:
        note(terminated(report.exit_code))
        raise typer.Exit(report.exit_code)
    if report.interrupted:
        raise KeyboardInterrupt
    if not report.is_well:
        if view.speaks_json:
            raise typer.Exit(1)
        raise EndocalError(summary(report))
    if not quiet and not view.speaks_json:
        note(summary(report))


def _print_plan(plan: Plan, as_json: bool, quiet: bool) -> None:
    """Print one line a recording: what would be done with it, and why."""
    from ..batch.report import lens_words
    from ..files.names import shown
    from .batch_view import escaped, plain

    for step in plan.steps:
        place, source = step.recording.place, step.recording.source
        if as_json:
            row = {"action": step.action, "output": place, "source": source, "reason": step.reason}
            row |= lens_words(step.calibrations, step.recording.serial)
            print_json({key: escaped(value) for key, value in row.items()})
        else:
            names = " and ".join(
                f"{shown(path)} (sha256 {digest[:12]})" for path, digest in step.calibrations
            )
            serial = step.recording.serial
            scope = "" if serial is None else f", serial {shown(serial)}"
            typer.echo(
                plain(f"{step.action:<6} {shown(place)}: {step.reason}; with {names}{scope}")
            )
    if quiet:
        return
    for text in (*plan.notes, *plan.missing):
        note(plain(text))
    note(f"{len(plan.todo)} of {len(plan.steps)} recordings have work; nothing was touched")
