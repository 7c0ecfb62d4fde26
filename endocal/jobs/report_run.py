"""The page of a correction: the job behind ``endocal correct --report``."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

from ..errors import UsageError
from ..files import load
from ..files.names import shown
from ..report.numbers import duration
from ..report.page import Html
from ..report.run import Run, ZoomHistory, run_page
from ..zoom.table import ZoomTable
from .correct import correct, holds_picture
from .correction import CorrectionReport, CorrectionSpec, Progress
from .page_place import check_page_place
from .pipe import PIPE
from .report import write_page
from .zoom_history import zoom_history


def correct_and_report(
    spec: CorrectionSpec, page: str, progress: Callable[[Progress], None] | None = None
) -> CorrectionReport:
    """Correct as ``correct`` does, then write the page of it; a zoom is shown by its log.

    Raises, before any work, UsageError for a page that shares its place with an output, OutputError where
    it cannot be written, and EndocalError where matplotlib is missing.
    """
    _check(spec, page)
    with _with_log(spec) as logging:
        report = correct(logging, progress)
        log = logging.zoom_log
        zoom = zoom_history(log) if log is not None and report.frames else None
    write_page(_page(report, zoom, _calibrated(spec, report)), page, spec.overwrite)
    return report


def _check(spec: CorrectionSpec, page: str) -> None:
    if spec.calibration == PIPE:
        raise UsageError("--report needs the calibration as a file, not from stdin")
    if spec.input != PIPE and holds_picture(spec.input):
        raise UsageError(f"--report is for videos; {shown(spec.input)} is a picture")
    others = (spec.output, spec.zoom_log)
    if page in others or os.path.realpath(page) in [os.path.realpath(o) for o in others if o]:
        raise UsageError(f"--report {page}: is also another output: give it another name")
    inputs = (spec.input, spec.calibration, spec.right_calibration, spec.zoom_from)
    check_page_place(page, spec.overwrite, inputs)


@contextlib.contextmanager
def _with_log(spec: CorrectionSpec) -> Iterator[CorrectionSpec]:
    """Give a correction that follows a zoom, and keeps no log, a temporary one."""
    follows = spec.stereo is None and isinstance(load(spec.calibration), ZoomTable)
    if spec.zoom_log is not None or not follows:
        yield spec
        return
    with tempfile.TemporaryDirectory(prefix="endocal-") as folder:
        yield replace(spec, zoom_log=str(Path(folder) / "zoom.csv"))


def _calibrated(spec: CorrectionSpec, report: CorrectionReport) -> tuple[float, float] | None:
    """The diameters that the zoom table spans, px of the frames that were corrected."""
    lens = load(spec.calibration)
    if not isinstance(lens, ZoomTable):
        return None
    # A diameter counts in px of the frame's height.
    scale = report.size_in[1] / lens.size[1]
    return lens.settings[0].diameter * scale, lens.settings[-1].diameter * scale


def _page(
    report: CorrectionReport, zoom: ZoomHistory | None, calibrated: tuple[float, float] | None
) -> Html:
    rate = report.frames / report.seconds if report.seconds else 0.0
    (w, h), (wide, high) = report.size_in, report.size_out
    facts = [
        ("input", report.input),
        ("output", report.output),
        ("frames", f"{report.frames} of {w}x{h} px"),
        ("written as", f"{wide}x{high} px" + (f", {report.codec}" if report.codec else "")),
        ("took", f"{duration(report.seconds)} ({rate:.0f} frames a second)"),
        ("device", report.device),
    ]
    if report.duration is not None:
        facts.insert(2, ("length", duration(report.duration)))
    run = Run(facts, report.notes, report.warnings, calibrated)
    return run_page(f"Correction: {Path(report.input).name}", zoom, run)
