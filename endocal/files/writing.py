"""TOML text with a comment on each unit, the same bytes for the same values.

Laid out line by line because TOML writers keep no comments, and the units belong beside the numbers; strings
are tomli-w's. Only what our two documents hold is covered: strings, numbers, flags, and lists of them.
"""

from __future__ import annotations

import math

import tomli_w

from ..errors import InputError
from .names import as_text

# Digits of a number that comes without an uncertainty: far finer than any lens is known, far coarser than
# what the order of a sum changes.
_SIGNIFICANT = 9
# Digits kept below the leading digit of the uncertainty, and of the uncertainty itself.
_BELOW_UNCERTAINTY = 2
_UNCERTAINTY_DIGITS = 3

_COMMENT_COLUMN = 29


def rounded(value: float, uncertainty: float | None = None) -> float:
    """Round a number to between 1/100 and 1/1000 of its uncertainty, or to 9 significant digits.

    Rounding a rounded number changes nothing. Raises InputError for a value that is not finite.
    """
    if not math.isfinite(value):
        raise InputError(f"the value {value} is not a finite number and cannot be written")
    digits = _SIGNIFICANT
    if uncertainty and value:
        leading = _exponent(rounded_uncertainty(uncertainty))
        digits = _exponent(value) - leading + _BELOW_UNCERTAINTY + 1
        if digits < 1:
            # Far smaller than its own uncertainty: one digit is enough to say so.
            digits = 1
    # + 0.0 turns a negative zero into zero.
    return float(f"{value:.{min(digits, 15) - 1}e}") + 0.0


def rounded_place(value: float) -> float:
    """Round a place or a length in px to 1e-4 px, finer than any rim or centre is found."""
    return round(rounded(value), 4) + 0.0


def rounded_area(value: float) -> float:
    """Round an area in px^2 to a tenth."""
    return round(rounded(value), 1) + 0.0


def rounded_uncertainty(value: float) -> float:
    """Round an uncertainty to 3 significant digits; InputError for one that is not finite."""
    if not math.isfinite(value):
        raise InputError(f"the uncertainty {value} is not a finite number and cannot be written")
    return float(f"{value:.{_UNCERTAINTY_DIGITS - 1}e}") + 0.0


def _exponent(value: float) -> int:
    return math.floor(math.log10(abs(value)))


def number(value: float) -> str:
    """Return a float in TOML's notation, the shortest that reads back the same."""
    mantissa, _, exponent = repr(float(value)).partition("e")
    return f"{mantissa}e{int(exponent)}" if exponent else mantissa


def numbers(values: tuple[float, ...]) -> str:
    """Return a list of floats."""
    return f"[{', '.join(number(v) for v in values)}]"


def text(value: str) -> str:
    """Return a string, everything escaped that TOML or a terminal could take for something else.

    The bytes of a file name that are no valid Unicode become question marks.
    """
    quoted = tomli_w.dumps({"key": as_text(value)}).removeprefix("key = ").rstrip("\n")
    return "".join(c if c.isprintable() else f"\\U{ord(c):08x}" for c in quoted)


def texts(values: tuple[str, ...]) -> str:
    """Return a list of strings, one a line when there are several."""
    return _listed([text(v) for v in values])


def inline_tables(rows: list[dict[str, str]]) -> str:
    """Return a list of inline tables, one a line when there are several; the values are TOML already."""
    return _listed([inline_table(row) for row in rows])


def inline_table(row: dict[str, str]) -> str:
    """Return one inline table; the values are TOML already."""
    return f"{{ {', '.join(f'{k} = {v}' for k, v in row.items())} }}"


def line(key: str, value: str, comment: str = "") -> str:
    """Return ``key = value  # comment`` with the comments of a section in one column."""
    entry = f"{key} = {value}"
    return f"{entry:<{_COMMENT_COLUMN - 1}} # {comment}" if comment else entry


def _listed(items: list[str]) -> str:
    if len(items) < 2:
        return f"[{', '.join(items)}]"
    return "[\n" + "".join(f"    {item},\n" for item in items) + "]"
