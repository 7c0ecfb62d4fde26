"""A calibration or a zoom table in words, for people, and as plain data, for programs."""

from __future__ import annotations

import tomllib
from typing import Any

from ..boundary.content import content_radius
from ..calibration.result import Calibration
from ..files import dumps
from ..model import DivisionModel
from ..zoom.table import ZoomTable

Row = tuple[str, str]


def as_data(obj: Calibration | ZoomTable) -> dict[str, Any]:
    """Return what the TOML file holds, under the same keys."""
    return tomllib.loads(dumps(obj))


def describe(obj: Calibration | ZoomTable) -> list[Row]:
    """Return (label, text) rows that say what a calibration or a zoom table holds."""
    return _describe_table(obj) if isinstance(obj, ZoomTable) else _describe_calibration(obj)


def _describe_calibration(calibration: Calibration) -> list[Row]:
    model, u, b = calibration.model, calibration.uncertainty, calibration.boundary
    rows = [("frame", _frame(model.size, model.pixel_aspect))]
    rows.append(("lambda", f"{model.lam:.6g}{f' ± {u.lam:.2g}' if u else ''} px^-2"))
    if model.lam2:
        sigma = f" ± {u.lam2:.2g}" if u and u.lam2 is not None else ""
        rows.append(("lambda2", f"{model.lam2:.6g}{sigma} px^-4"))
    sigma = f" ± {u.center[0]:.2g}, {u.center[1]:.2g}" if u and not u.center_given else ""
    given = " as given" if u and u.center_given else ""
    rows.append(("centre", f"{model.center[0]:.2f}, {model.center[1]:.2f}{sigma} px{given}"))
    reach = content_radius(model.center, model.size, b, model.pixel_aspect)
    usable = calibration.usable_radius
    rows.append(("effect", _effect(model, min(reach, usable or reach))))
    if usable is not None:
        rows.append(
            ("usable", f"up to {usable:.0f} px from the centre; what lies farther out is lost")
        )
    if b is None:
        rows.append(("boundary", "none visible"))
    else:
        rows.append(
            ("boundary", f"{b.diameter:.1f} px wide, {b.visible:.0%} of its rim in the frame")
        )
    if (q := calibration.quality) is not None:
        rows.append(
            ("verdict", ": ".join([q.verdict, "; ".join(q.reasons)]) if q.reasons else q.verdict)
        )
        if q.rms_before is not None and q.rms is not None:
            found = f"{q.points} edge points on {q.lines} lines"
            without = (
                f" but {q.outlying_told:.0%} that do not follow them" if q.outlying_told else ""
            )
            over = f"{found}{without}"
            rows.append(("straightness", f"{q.rms_before:.2f} -> {q.rms:.2f} px over {over}"))
    if (s := calibration.source) is not None:
        refined = "" if s.refined else ", not refined"
        rows.append(("made by", f"endocal {s.endocal}, method {s.method}{refined}"))
        rows += [("picture", image.file) for image in s.images]
    return rows


def _describe_table(table: ZoomTable) -> list[Row]:
    law = table.law
    rows = [
        ("frame", _frame(table.size, table.pixel_aspect)),
        ("law", f"lambda * diameter^2 = {law.lambda_diameter2:.4g}, spread {law.spread:.2%}"),
    ]
    for i, (setting, departure) in enumerate(zip(table.settings, law.departures, strict=True), 1):
        lam2 = f", lambda2 {setting.lam2:.5g} px^-4" if setting.lam2 else ""
        outlier = ", stands out from the others" if law.outlier == i - 1 else ""
        x, y = setting.center
        rows.append(
            (
                f"setting {i}",
                f"diameter {setting.diameter:.1f} px: lambda {setting.lam:.5g} px^-2{lam2},"
                f" centre {x:.2f}, {y:.2f} px, {departure:+.2%} off the law{outlier}",
            )
        )
    return rows


def _frame(size: tuple[int, int], pixel_aspect: float) -> str:
    shape = "" if pixel_aspect == 1 else f", pixels {pixel_aspect:.4g} times as wide as high"
    return f"{size[0]}x{size[1]} px{shape}"


def _effect(model: DivisionModel, reach: float) -> str:
    """Say how far the correction moves the farthest content, the measure of a lens that people see."""
    strength = model.lam * reach**2 + model.lam2 * reach**4
    kind = "barrel" if strength < 0 else "pincushion" if strength > 0 else "none"
    return (
        f"{kind}: content {reach:.0f} px from the centre moves to {reach / (1 + strength):.0f} px"
    )
