"""Make a zoom table from pattern images or calibrations: the job behind ``endocal zoomtable``."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from ..calibration.result import Calibration
from ..calibration.spec import CalibrationSpec
from ..errors import CalibrationError, InputError
from ..files import check_output, load, read_picture_bytes, save
from ..files.names import shown
from ..files.picture_header import SIGNATURE_BYTES, known_kind
from ..zoom.table import Setting, SettingSource, ZoomTable

# A law that spreads more than this is worth a note, even where no single setting stands out.
_WIDE_SPREAD = 0.05


@dataclass(frozen=True)
class ZoomTableSpec:
    """What to make a table of.

    ``items`` are paths of pattern images, each at one zoom setting, or of calibrations; images are
    calibrated by ``calibration``. The table goes to ``output``.
    """

    items: tuple[str, ...]
    output: str
    calibration: CalibrationSpec = field(default_factory=CalibrationSpec)
    overwrite: bool = False


@dataclass(frozen=True)
class ZoomTableReport:
    """The table, where it was written, and what is to be said about it in plain words."""

    table: ZoomTable
    output: str
    notes: tuple[str, ...]


def make_zoomtable(
    spec: ZoomTableSpec, progress: Callable[[str], None] = lambda item: None
) -> ZoomTableReport:
    """Calibrate or read each item, check that they are one lens, and write the table.

    ``progress`` is called with each item's name before it is worked on. Raises InputError for an item that
    cannot be read or shows no circle, for items of different frame sizes, and for those that ZoomTable
    refuses; CalibrationError for an image that gives no trustworthy calibration; OutputError where the
    table cannot be written.
    """
    check_output(spec.output, spec.overwrite, spec.items)
    notes: list[str] = []
    first: tuple[str, Calibration] | None = None
    settings = []
    for item in spec.items:
        progress(item)
        calibration = _calibration(item, spec.calibration, notes)
        if first is None:
            first = (item, calibration)
        else:
            _check_same_frame(first, (item, calibration))
        settings.append(_setting(item, calibration))
        quality = calibration.quality
        if quality is not None and quality.verdict != "good":
            reasons = "; ".join(quality.reasons)
            notes.append(f"{shown(item)} is {quality.verdict}{': ' if reasons else ''}{reasons}")
    if first is None:
        raise InputError("a zoom table needs 2 settings or more: name their images or calibrations")
    model = first[1].model
    table = ZoomTable(tuple(settings), model.size, model.pixel_aspect)
    notes += _law_notes(table)
    save(table, spec.output, overwrite=spec.overwrite)
    return ZoomTableReport(table, spec.output, tuple(notes))


def _calibration(item: str, spec: CalibrationSpec, notes: list[str]) -> Calibration:
    """Calibrate a picture, with ``notes`` of it, or read a calibration."""
    if _is_picture(item):
        from .calibrate import report_files

        report = report_files([item], spec)
        notes += report.notes
        calibration = report.calibration
        quality = calibration.quality
        if quality is not None and quality.verdict == "failed":
            raise CalibrationError(f"{shown(item)}: {quality.reasons[0]}")
        return calibration
    obj = load(item)
    if not isinstance(obj, Calibration):
        raise InputError(
            f"{shown(item)}: is a zoom table; name the calibrations of single settings"
        )
    return obj


def _is_picture(item: str) -> bool:
    try:
        with open(item, "rb") as file:
            return known_kind(file.read(SIGNATURE_BYTES))
    except OSError:
        # Told as a calibration that is missing or cannot be read.
        return False


def _check_same_frame(first: tuple[str, Calibration], other: tuple[str, Calibration]) -> None:
    a, b = first[1].model, other[1].model
    if a.size != b.size or a.pixel_aspect != b.pixel_aspect:
        raise InputError(
            f"{shown(other[0])} is for frames of {_frame(other[1])}, but {shown(first[0])} for"
            f" {_frame(first[1])}: all settings of a table need the same frame"
        )


def _frame(calibration: Calibration) -> str:
    model = calibration.model
    aspect = "" if model.pixel_aspect == 1 else f" with a pixel aspect of {model.pixel_aspect:g}"
    return f"{model.size[0]}x{model.size[1]}{aspect}"


def _setting(item: str, calibration: Calibration) -> Setting:
    boundary = calibration.boundary
    if boundary is None:
        raise InputError(
            f"{shown(item)}: no visible circle, so that its zoom setting has no diameter: use a picture"
            " that shows the circle's rim"
        )
    model = calibration.model
    data = read_picture_bytes(item) if _is_picture(item) else Path(item).read_bytes()
    source = SettingSource(Path(item).name, hashlib.sha256(data).hexdigest())
    return Setting(
        model.lam,
        model.center,
        boundary.diameter,
        boundary.area,
        model.lam2,
        source,
        boundary.center,
    )


def _law_notes(table: ZoomTable) -> list[str]:
    law = table.law
    if law.outlier is not None:
        setting = table.settings[law.outlier]
        return [
            f"the setting at diameter {setting.title} stands out from the law by"
            f" {law.departures[law.outlier]:+.1%}: calibrate it again or leave it out"
        ]
    if law.spread > _WIDE_SPREAD:
        return [
            f"the settings spread by {law.spread:.1%} about the law lambda * diameter^2 = constant"
        ]
    return []
