"""The options of a calibration that are kept with it, so that it can be made again."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from .result import Calibration, Source
from .spec import CalibrationSpec

# Fields of CalibrationSpec that are kept under names of their own: in Source and in the model. A model that
# was asked for and not found is among the options.
ELSEWHERE = ("method", "refine", "model", "pixel_aspect")
RECORDED = ("center", "samples", "epsilon", "max_rounds", "center_region", "sobel", "roi", "lines")


def options_of(spec: CalibrationSpec, calibration: Calibration) -> dict[str, Any]:
    """Return what ``spec`` asked for that neither the defaults nor the ``calibration`` made with it tell.

    By the names of its fields.
    """
    told = {f.name: f.default for f in fields(CalibrationSpec)} | {"model": _model_of(calibration)}
    values = {name: getattr(spec, name) for name in (*RECORDED, "model")}
    return {name: value for name, value in values.items() if value != told[name]}


def spec_of(calibration: Calibration) -> CalibrationSpec:
    """Return the options that a calibration was made with; UsageError where they make no sense."""
    source = calibration.source or Source()
    return CalibrationSpec(
        method=source.method,
        refine=source.refined,
        pixel_aspect=calibration.model.pixel_aspect,
        **{"model": _model_of(calibration), **source.options},
    )


def _model_of(calibration: Calibration) -> str:
    """The model by how many parameters were found."""
    # A lambda2 that is nothing beside its uncertainty is written as 0.
    second = calibration.uncertainty is not None and calibration.uncertainty.lam2 is not None
    return "division2" if calibration.model.lam2 or second else "division"
