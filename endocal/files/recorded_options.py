"""The key ``[source] options``: what a calibration was told to do differently from the defaults."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from ..calibration.spec import MODELS
from ..errors import InputError
from . import writing as w
from .section import Section


def read(section: Section) -> dict[str, Any]:
    """Return the options of a table, each checked for its type; an absent table is empty."""
    if not section.has("options"):
        return {}
    options = section.section("options", f"{section.name('options')}:")
    found = {key: reader(options, key) for key, reader in _READERS.items() if options.has(key)}
    options.close()
    return found


def write(options: Mapping[str, Any]) -> list[str]:
    """Return the line of the document, or none where every option was as by default."""
    if not options:
        return []
    return [w.line("options", w.inline_table({k: _text(v) for k, v in options.items()}))]


def _text(value: Any) -> str:
    if isinstance(value, str):
        return w.text(value)
    if isinstance(value, tuple):
        return f"[{', '.join(_text(v) for v in value)}]"
    return str(value) if isinstance(value, int) else w.number(value)


def _read_center(section: Section, key: str) -> str | tuple[float, float]:
    value = section.get(key)
    return value if isinstance(value, str) else section.pair(key)


def _read_roi(section: Section, key: str) -> tuple[int, int, int, int]:
    value = section.get(key)
    if not isinstance(value, list) or len(value) != 4 or any(type(v) is not int for v in value):
        raise InputError(
            f"{section.name(key)} is {str(value)[:40]!r}; it must be [x, y, width, height] in px"
        )
    x, y, width, height = value
    return x, y, width, height


def _read_lines(section: Section, key: str) -> tuple[tuple[tuple[float, float], ...], ...]:
    value = section.get(key)
    try:
        return tuple(tuple((float(x), float(y)) for x, y in line) for line in value)
    except (TypeError, ValueError):
        raise InputError(
            f"{section.name(key)} must be a list of lines, each a list of points [x, y] in px"
        ) from None


def _read_model(section: Section, key: str) -> str:
    return section.choice(key, MODELS)


# Option -> how its value is read. The names are those of CalibrationSpec's fields.
_READERS: dict[str, Callable[[Section, str], Any]] = {
    "center": _read_center,
    "samples": Section.integer,
    "epsilon": Section.number,
    "max_rounds": Section.integer,
    "center_region": Section.number,
    "sobel": Section.integer,
    "roi": _read_roi,
    "lines": _read_lines,
    "model": _read_model,
}
