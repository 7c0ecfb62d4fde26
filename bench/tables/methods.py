"""Every method on every picture: what Tables II and III are made of."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context

import cv2
import numpy as np

from endocal.calibration.calibrate import calibrate
from endocal.calibration.evaluate import evaluate
from endocal.calibration.spec import CalibrationSpec
from endocal.errors import CalibrationError
from endocal.model import DivisionModel

from .lenses import Case


@dataclass(frozen=True)
class Result:
    """A method on a picture; px. ``rmse`` and ``straightness`` are infinite where the model folds before a
    point; ``refused`` says why there is none. ``lam_error`` relative and ``center_error`` px: None without truth."""

    lens: str
    method: str
    rmse: float = math.nan
    straightness: float = math.nan
    lam_error: float | None = None
    center_error: float | None = None
    refused: str | None = None


def run(
    cases: Iterable[Case], methods: Sequence[str], centered: bool, processes: int
) -> list[Result]:
    """Run methods, bare, on pictures; with ``centered`` the distortion centre is given."""
    work = [(case, method, centered) for case in cases for method in methods]
    with ProcessPoolExecutor(processes, get_context("spawn"), _one_thread_each) as pool:
        return list(pool.map(_one, work))


def _one_thread_each() -> None:
    cv2.setNumThreads(1)


def _one(work: tuple[Case, str, bool]) -> Result:
    case, method, centered = work
    spec = CalibrationSpec(
        method="hewg" if method == "refined" else method,
        refine=method == "refined",
        center=case.center if centered else "free",
    )
    try:
        model = calibrate(case.image, spec).model
    except CalibrationError as error:
        return Result(case.lens, method, refused=str(error))
    found = evaluate(case.lines, model)
    lam_error, center_error = _errors(model, case.truth)
    return Result(case.lens, method, found.rmse, found.straightness, lam_error, center_error)


def _errors(model: DivisionModel, truth: DivisionModel | None) -> tuple[float | None, float | None]:
    if truth is None:
        return None, None
    away = np.subtract(model.center, truth.center)
    return model.lam / truth.lam - 1, float(np.hypot(*away))


def uncorrected(case: Case) -> Result:
    """The picture as it is."""
    w, h = case.image.shape[1], case.image.shape[0]
    found = evaluate(case.lines, DivisionModel(0.0, ((w - 1) / 2, (h - 1) / 2), (w, h)))
    return Result(case.lens, "as it is", found.rmse, found.straightness)


def mean(results: Sequence[Result], name: str) -> tuple[float | None, int]:
    """The mean of a measure over pictures, and on how many there is none."""
    values = [getattr(r, name) for r in results]
    held = [v for v in values if v is not None and math.isfinite(v)]
    return (float(np.mean(held)) if held else None), len(values) - len(held)
