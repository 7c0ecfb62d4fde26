"""The options of a calibration that are kept with it, so that it can be made again."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from .result import Calibration, Source
from .spec import CalibrationSpec

# Fields of CalibrationSpec that are kept under names of their own: in Source and in the model.
ELSEWHERE = ("method", "refine", "model", "pixel_aspect")
RECORDED = ("center", "samples", "epsilon", "max_rounds", "center_region", "sobel", "roi", "lines")


def options_of(spec: CalibrationSpec) -> dict[str, Any]:
    """Return those of the RECORDED options that are not as by default, by their names in the spec."""
    defaults = {f.name: f.default for f in fields(CalibrationSpec)}
    values = {name: getattr(spec, name) for name in RECORDED}
    return {name: value for name, value in values.items() if value != defaults[name]}


def spec_of(calibration: Calibration) -> CalibrationSpec:
    """Return the options that a calibration was made with; UsageError where they make no sense."""
    source, model = calibration.source or Source(), calibration.model
    # A lambda2 that is nothing beside its uncertainty is written as 0.
    second = calibration.uncertainty is not None and calibration.uncertainty.lam2 is not None
    return CalibrationSpec(
        method=source.method,
        refine=source.refined,
        model="division2" if model.lam2 or second else "division",
        pixel_aspect=model.pixel_aspect,
        **source.options,
    )
