"""Pages that show a calibration, a zoom table or a zoom log: the job behind ``endocal report``."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from ..calibration.recorded import spec_of
from ..calibration.result import Calibration
from ..errors import EndocalError, InputError, UsageError
from ..files import atomic_output, dumps, load, loads
from ..files.names import shown
from ..report.calibration import Study, calibration_page
from ..report.figures import require_figures
from ..report.page import Html
from ..report.run import run_page
from ..report.zoom_table import zoom_table_page
from ..zoom.table import ZoomTable
from .calibrate import CalibrationReport, report_files
from .check import compared
from .page_place import check_page_place
from .pipe import PIPE
from .recorded_pictures import find_picture
from .zoom_history import zoom_history
from .zoom_log import LOG_SUFFIXES

# In stated standard deviations: less is what another version of endocal may make of the same picture.
MOVED = 1.0


@dataclass(frozen=True)
class ReportSpec:
    """What to show: ``file`` is a calibration, a zoom table (``-`` is stdin) or a zoom log.

    ``output`` is the page's path, by default the file's with the suffix .html. A calibration's pictures are
    looked for beside it, or anywhere below ``images``.
    """

    file: str
    output: str | None = None
    images: str | None = None
    overwrite: bool = False

    @property
    def page(self) -> str:
        """Where the page goes."""
        if self.output is not None:
            return self.output
        if self.file == PIPE:
            raise UsageError("with - as the file, name the page with --output")
        if not Path(self.file).name:
            raise InputError(f"{self.file or 'an empty name'}: is no file to make a page of")
        return str(Path(self.file).with_suffix(".html"))


@dataclass(frozen=True)
class ReportDone:
    """Where the page is, and what is to be said about it."""

    output: str
    notes: tuple[str, ...] = ()


def report(spec: ReportSpec) -> ReportDone:
    """Write the page of a file.

    Raises InputError for a file that is no calibration, zoom table or zoom log, OutputError for a page that
    exists, is an input (the calibration's pictures, too) or cannot be written, UsageError for one named as
    another kind of file, EndocalError where matplotlib is missing.
    """
    place = spec.page
    require_figures()
    name = "stdin" if spec.file == PIPE else Path(spec.file).name
    lens = None if Path(spec.file).suffix.lower() in LOG_SUFFIXES else load(spec.file)
    pictures, missing = _recorded(lens, spec) if isinstance(lens, Calibration) else ([], None)
    inputs = (spec.file, *pictures)
    check_page_place(place, spec.overwrite, inputs)
    notes: list[str] = []
    doubts: list[str] = []
    if lens is None:
        page = run_page(f"Zoom log: {name}", zoom_history(spec.file))
    elif isinstance(lens, ZoomTable):
        page = zoom_table_page(name, lens)
    else:
        study, notes, doubts = _study(lens, pictures, missing)
        page = calibration_page(name, lens, study, notes, doubts)
    write_page(page, place, spec.overwrite, inputs)
    return ReportDone(place, (*notes, *doubts))


def report_calibration(report: CalibrationReport, name: str, output: str, overwrite: bool) -> None:
    """Write the page of a calibration that was just made; ``name`` is what it is called."""
    calibration = _as_written(report.calibration)
    notes = [f"{shown(path)} was left out: {reason}" for path, reason in report.left_out]
    study = Study(report.pictures, report.workings, report.spec)
    write_page(calibration_page(name, calibration, study, notes), output, overwrite)


def report_table(table: ZoomTable, name: str, output: str, overwrite: bool) -> None:
    """Write the page of a zoom table; ``name`` is what it is called."""
    write_page(zoom_table_page(name, table), output, overwrite)


def write_page(page: Html, output: str, overwrite: bool, inputs: Iterable[str] = ()) -> None:
    """Write a page; ``-`` is standard output. Raises OutputError, see ``atomic_output``."""
    data = page.encode("utf-8", "replace")
    if os.fspath(output) == PIPE:
        sys.stdout.buffer.write(data)
        sys.stdout.buffer.flush()
        return
    with atomic_output(output, overwrite, [i for i in inputs if i != PIPE]) as temporary:
        temporary.write_bytes(data)


def _recorded(recorded: Calibration, spec: ReportSpec) -> tuple[list[str], EndocalError | None]:
    """The paths of the recorded pictures that are there, and why the first of the others is not."""
    paths: list[str] = []
    missing: EndocalError | None = None
    for image in recorded.source.images if recorded.source else ():
        try:
            paths.append(find_picture(image, spec.file, spec.images))
        except EndocalError as error:
            missing = missing or error
    return paths, missing


def _study(
    recorded: Calibration, pictures: list[str], missing: EndocalError | None
) -> tuple[Study | None, list[str], list[str]]:
    """Calibrate again from the recorded pictures; notes say why not, and doubts what moved."""
    if not pictures and missing is None:
        return None, ["The file names no picture, so that only its numbers can be shown."], []
    try:
        if missing is not None:
            raise missing
        made = report_files(pictures, spec_of(recorded))
        found = loads(dumps(made.calibration))
    except EndocalError as error:
        return None, [f"Only the numbers can be shown. {error}"], []
    assert isinstance(found, Calibration)
    return Study(made.pictures, made.workings, made.spec), [], _moved(recorded, found)


def _as_written(calibration: Calibration) -> Calibration:
    """Return a calibration with the digits that its file has; one that no file can hold as it is."""
    try:
        written = loads(dumps(calibration))
    except InputError:
        return calibration
    assert isinstance(written, Calibration)
    return written


def _moved(recorded: Calibration, found: Calibration) -> list[str]:
    moved = [str(n) for n in compared(recorded, found, MOVED) if not n.passed]
    if not moved:
        return []
    return [
        "Made again from its pictures, the calibration came out otherwise:"
        f" {'; '.join(moved)}. The numbers are those of the file, the figures those of now."
    ]
