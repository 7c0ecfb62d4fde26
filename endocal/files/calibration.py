"""A Calibration as a TOML document and back (schema ``endocal.calibration/1``)."""

from __future__ import annotations

from typing import Any

from ..boundary.circle import Boundary
from ..boundary.content import content_radius
from ..calibration.result import (
    VERDICTS,
    Calibration,
    Quality,
    Source,
    SourceImage,
    Uncertainty,
)
from ..calibration.spec import PIXEL_ASPECTS
from ..errors import InputError
from ..model import DivisionModel
from . import recorded_options
from . import writing as w
from .section import Section

SCHEMA = "endocal.calibration"
VERSION = 1

_ONE_PARAMETER, _TWO_PARAMETERS = "division", "division2"


def read(document: Section) -> Calibration:
    """Return the calibration that a document holds; InputError where it is not a sound one."""
    model, usable_radius = _read_model(document.section("model"))
    calibration = Calibration(
        model,
        uncertainty=_optional(document, "uncertainty", _read_uncertainty),
        boundary=_optional(document, "boundary", _read_boundary),
        quality=_optional(document, "quality", _read_quality),
        source=_optional(document, "source", _read_source),
        usable_radius=usable_radius,
    )
    document.close()
    _check_fold(calibration)
    return calibration


def write(calibration: Calibration) -> list[str]:
    """Return the lines of the document, rounded well below the stated uncertainty."""
    lines = [f'schema = "{SCHEMA}/{VERSION}"', *_write_model(calibration)]
    if calibration.uncertainty is not None:
        lines += _write_uncertainty(calibration.uncertainty)
    if calibration.boundary is not None:
        lines += _write_boundary(calibration.boundary)
    if calibration.quality is not None:
        lines += _write_quality(calibration.quality)
    if calibration.source is not None:
        lines += _write_source(calibration.source)
    return lines


def _optional(document: Section, key: str, reader: Any) -> Any:
    return reader(document.section(key)) if document.has(key) else None


def _read_model(section: Section) -> tuple[DivisionModel, float | None]:
    two = section.choice("type", (_ONE_PARAMETER, _TWO_PARAMETERS)) == _TWO_PARAMETERS
    values = {
        "lam": section.number("lambda"),
        "center": section.pair("center"),
        "size": section.size("size"),
        "pixel_aspect": section.number_within("pixel_aspect", PIXEL_ASPECTS, 1.0),
        "lam2": section.number("lambda2") if two else 0.0,
    }
    if not two and section.has("lambda2"):
        raise InputError(f'{section.name("lambda2")} needs type = "{_TWO_PARAMETERS}"')
    usable_radius = section.number("usable_radius", None, at_least=0)
    section.close()
    try:
        return DivisionModel(**values), usable_radius
    except InputError as error:
        raise InputError(f"[model] {error}") from None


def _check_fold(calibration: Calibration) -> None:
    """Refuse a model whose map folds over before the end of the content that it is to correct."""
    model = calibration.model
    reach = content_radius(model.center, model.size, calibration.boundary, model.pixel_aspect)
    content = "frame" if calibration.boundary is None else "visible circle"
    if calibration.usable_radius is not None:
        reach, content = min(reach, calibration.usable_radius), "usable_radius"
    if model.valid_radius > reach:
        return
    advice = "check its unit, px^-2"
    if calibration.boundary is None:
        advice += ", or give the visible circle in [boundary]"
    raise InputError(
        f"[model] lambda {model.lam:g} folds the picture over {model.valid_radius:.1f} px from the"
        f" centre, inside its own {content}, which reaches {reach:.1f} px: {advice}"
    )


def _write_model(calibration: Calibration) -> list[str]:
    model, u = calibration.model, calibration.uncertainty
    two = model.lam2 != 0
    lines = ["", "[model]"]
    if two:
        formula = "r_u = r_d / (1 + lambda r_d^2 + lambda2 r_d^4)"
        lines.append(w.line("type", w.text(_TWO_PARAMETERS), formula))
    else:
        lines.append(w.line("type", w.text(_ONE_PARAMETER), "r_u = r_d / (1 + lambda r_d^2)"))
    lines.append(w.line("lambda", w.number(w.rounded(model.lam, u.lam if u else None)), "px^-2"))
    if two:
        value = w.rounded(model.lam2, u.lam2 if u else None)
        lines.append(w.line("lambda2", w.number(value), "px^-4"))
    x, y = (w.rounded(model.center[i], u.center[i] if u else None) for i in (0, 1))
    return [
        *lines,
        w.line("center", w.numbers((x, y)), "x, y, px"),
        w.line("size", f"[{model.size[0]}, {model.size[1]}]", "width, height, px"),
        w.line("pixel_aspect", w.number(model.pixel_aspect), "a pixel's width over its height"),
        *_write_usable_radius(calibration.usable_radius),
    ]


def _write_usable_radius(radius: float | None) -> list[str]:
    if radius is None:
        return []
    return [w.line("usable_radius", w.number(round(radius, 1)), "px; the map folds farther out")]


def _read_uncertainty(section: Section) -> Uncertainty:
    uncertainty = Uncertainty(
        lam=section.number("lambda", at_least=0),
        center=section.pair("center", at_least=0),
        lam2=section.number("lambda2", None, at_least=0),
    )
    section.close()
    return uncertainty


def _write_uncertainty(uncertainty: Uncertainty) -> list[str]:
    lam = w.number(w.rounded_uncertainty(uncertainty.lam))
    x, y = (w.rounded_uncertainty(v) for v in uncertainty.center)
    lines = [
        "",
        "[uncertainty]                # one standard deviation",
        w.line("lambda", lam, "px^-2"),
    ]
    if uncertainty.lam2 is not None:
        lam2 = w.number(w.rounded_uncertainty(uncertainty.lam2))
        lines.append(w.line("lambda2", lam2, "px^-4"))
    return [*lines, w.line("center", w.numbers((x, y)), "x, y, px")]


def _read_boundary(section: Section) -> Boundary:
    boundary = Boundary(
        center=section.pair("center"),
        diameter=section.number("diameter"),
        area=section.number("area", 0.0, at_least=0),
        visible=section.number("visible", 1.0, at_least=0),
    )
    section.close()
    if boundary.diameter <= 0:
        raise InputError(
            f"{section.name('diameter')} is {boundary.diameter:g}; it must be positive"
        )
    if boundary.visible > 1:
        raise InputError(f"{section.name('visible')} is {boundary.visible:g}; it must be 0 to 1")
    return boundary


def _write_boundary(boundary: Boundary) -> list[str]:
    x, y = (w.rounded_place(v) for v in boundary.center)
    visible = w.number(round(w.rounded(boundary.visible), 4) + 0.0)
    return [
        "",
        "[boundary]                   # the visible circle",
        w.line("center", w.numbers((x, y)), "x, y, px"),
        w.line("diameter", w.number(w.rounded_place(boundary.diameter)), "px"),
        w.line("area", w.number(w.rounded_area(boundary.area)), "px^2, visible"),
        w.line("visible", visible, "fraction of the circumference"),
    ]


def _read_quality(section: Section) -> Quality:
    quality = Quality(
        verdict=section.choice("verdict", VERDICTS),
        reasons=section.texts("reasons"),
        lines=section.integer("lines", 0),
        points=section.integer("points", 0),
        rms_before=section.number("rms_before", None, at_least=0),
        rms=section.number("rms", None, at_least=0),
        entropy=section.number("entropy", None, at_least=0),
        outlying=section.number("outlying", 0.0, at_least=0),
    )
    section.close()
    if quality.outlying > 1:
        raise InputError(f"{section.name('outlying')} is {quality.outlying:g}; it must be 0 to 1")
    return quality


def _write_quality(quality: Quality) -> list[str]:
    lines = [
        "",
        "[quality]",
        w.line("verdict", w.text(quality.verdict), " | ".join(VERDICTS)),
        w.line("reasons", w.texts(quality.reasons)),
        w.line("lines", str(quality.lines)),
        w.line("points", str(quality.points)),
    ]
    for key, value, comment in (
        ("rms_before", quality.rms_before, "px, straightness of the lines before correction"),
        ("rms", quality.rms, "px, and after"),
        ("outlying", quality.outlying_told, "share of points that follow no line, left out of rms"),
        ("entropy", quality.entropy, "of the vote map, eq. 6"),
    ):
        if value is not None:
            lines.append(w.line(key, w.number(round(w.rounded(value), 4) + 0.0), comment))
    return lines


def _read_source(section: Section) -> Source:
    images = []
    for image in section.sections("images", f"{section.name('images')}, number"):
        images.append(
            SourceImage(image.text("file"), image.text("sha256", ""), image.number("rms", None))
        )
        image.close()
    source = Source(
        method=section.text("method", "hewg"),
        refined=section.flag("refined", True),
        images=tuple(images),
        endocal=section.text("endocal", ""),
        options=recorded_options.read(section),
    )
    section.close()
    return source


def _write_source(source: Source) -> list[str]:
    rows = []
    for image in source.images:
        row = {"file": w.text(image.file), "sha256": w.text(image.sha256)}
        if image.rms is not None:
            row["rms"] = w.number(round(image.rms, 4))
        rows.append(row)
    return [
        "",
        "[source]",
        w.line("method", w.text(source.method)),
        w.line("refined", "true" if source.refined else "false"),
        *recorded_options.write(source.options),
        w.line("images", w.inline_tables(rows)),
        w.line("endocal", w.text(source.endocal)),
    ]
