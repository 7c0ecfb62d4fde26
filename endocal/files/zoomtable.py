"""A ZoomTable as a TOML document and back (schema ``endocal.zoomtable/1``)."""

from __future__ import annotations

from dataclasses import replace

from ..calibration.spec import PIXEL_ASPECTS
from ..errors import InputError
from ..zoom.table import Setting, SettingSource, ZoomTable
from . import writing as w
from .section import Section

SCHEMA = "endocal.zoomtable"
VERSION = 1

# The law is written with so many digits after the point; a person may have rounded it, relative.
_LAW_DIGITS, _SAME_LAW = 6, 0.01


def read(document: Section) -> ZoomTable:
    """Return the zoom table that a document holds; InputError where it is not a sound one."""
    size = document.size("size")
    pixel_aspect = document.number_within("pixel_aspect", PIXEL_ASPECTS, 1.0)
    stated = _read_law(document.section("law")) if document.has("law") else None
    settings = tuple(_read_setting(s) for s in document.sections("setting", "[[setting]] number"))
    document.close()
    table = ZoomTable(settings, size, pixel_aspect)
    _check_law(stated, table)
    return table


def write(table: ZoomTable) -> list[str]:
    """Return the lines of the document."""
    # Rounded first, so that the law in the file is that of the settings in the file.
    settings = tuple(_rounded(setting) for setting in table.settings)
    law = ZoomTable(settings, table.size, table.pixel_aspect).law
    lines = [
        f'schema = "{SCHEMA}/{VERSION}"',
        w.line("size", f"[{table.size[0]}, {table.size[1]}]", "width, height, px"),
        w.line("pixel_aspect", w.number(table.pixel_aspect), "a pixel's width over its height"),
        "",
        "[law]                        # eq. 15: lambda * diameter^2 is one constant; for the reader",
        w.line(
            "lambda_diameter2", w.number(round(w.rounded(law.lambda_diameter2), _LAW_DIGITS) + 0.0)
        ),
        w.line(
            "spread", w.number(round(w.rounded(law.spread), 6) + 0.0), "relative, over the settings"
        ),
    ]
    for setting in settings:
        lines += _write_setting(setting)
    return lines


def _read_law(law: Section) -> float | None:
    """Return the constant of the law, which is in the file for the reader's eye: the settings hold it."""
    stated: float | None = law.number("lambda_diameter2", None)
    law.number("spread", None)
    law.close()
    return stated


def _check_law(stated: float | None, table: ZoomTable) -> None:
    """Refuse a law that contradicts the settings: one of the two was edited without the other."""
    if stated is None:
        return
    held = table.law.lambda_diameter2
    if abs(stated - held) > _SAME_LAW * max(abs(stated), abs(held)) + 10.0**-_LAW_DIGITS:
        raise InputError(
            f"[law] lambda_diameter2 is {stated:g}, but the settings give {held:g}: correct one of them, or"
            " leave [law] out"
        )


def _read_setting(section: Section) -> Setting:
    lam = section.number("lambda")
    lam2 = section.number("lambda2", 0.0)
    center = section.pair("center")
    diameter = section.number("diameter")
    area = section.number("area", None)
    circle = section.pair("circle") if section.has("circle") else None
    source = None
    if section.has("source"):
        inner = section.section("source", section.name("source,"))
        source = SettingSource(inner.text("file"), inner.text("sha256", ""))
        inner.close()
    section.close()
    try:
        return Setting(lam, center, diameter, area, lam2, source, circle)
    except InputError as error:
        raise InputError(f"{section.name(str(error))}") from None


def _rounded(setting: Setting) -> Setting:
    return replace(
        setting,
        lam=w.rounded(setting.lam),
        lam2=w.rounded(setting.lam2),
        center=_rounded_place(setting.center),
        circle=None if setting.circle is None else _rounded_place(setting.circle),
        diameter=w.rounded_place(setting.diameter),
        area=None if setting.area is None else w.rounded_area(setting.area),
    )


def _rounded_place(place: tuple[float, float]) -> tuple[float, float]:
    return w.rounded_place(place[0]), w.rounded_place(place[1])


def _write_setting(setting: Setting) -> list[str]:
    lines = ["", "[[setting]]", w.line("lambda", w.number(setting.lam), "px^-2")]
    if setting.lam2:
        lines.append(w.line("lambda2", w.number(setting.lam2), "px^-4"))
    lines += [
        w.line("center", w.numbers(setting.center), "x, y, px"),
        w.line("diameter", w.number(setting.diameter), "of the visible circle, px"),
    ]
    if setting.circle is not None:
        lines.append(w.line("circle", w.numbers(setting.circle), "its centre x, y, px"))
    if setting.area is not None:
        lines.append(w.line("area", w.number(setting.area), "px^2, visible"))
    if setting.source is not None:
        row = {"file": w.text(setting.source.file)}
        if setting.source.sha256:
            row["sha256"] = w.text(setting.source.sha256)
        lines.append(w.line("source", w.inline_table(row)))
    return lines
