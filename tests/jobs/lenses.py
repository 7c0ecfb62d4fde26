"""Calibrations and zoom tables written for a test."""

from __future__ import annotations

from pathlib import Path

from endocal.calibration.result import Calibration
from endocal.files import save
from endocal.model import DivisionModel
from endocal.zoom.table import Setting, ZoomTable


def calibration(
    path: Path,
    lam: float = 0.0,
    center: tuple[float, float] = (30.0, 25.0),
    size: tuple[int, int] = (64, 48),
    pixel_aspect: float = 1.0,
) -> str:
    """Save a calibration and return its path."""
    save(Calibration(DivisionModel(lam, center, size, pixel_aspect)), path, overwrite=True)
    return str(path)


def zoom_table(path: Path, size: tuple[int, int], diameters: tuple[float, ...]) -> str:
    """Save a table that obeys the law lambda * diameter^2 = -0.8, centred in the frame."""
    center = ((size[0] - 1) / 2, (size[1] - 1) / 2)
    settings = tuple(Setting(-0.8 / d**2, center, d) for d in diameters)
    save(ZoomTable(settings, size), path, overwrite=True)
    return str(path)
