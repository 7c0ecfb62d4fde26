"""A table of a TOML document, read key by key: each value checked, each unknown key named."""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping
from typing import Any

from ..errors import InputError


class Section:
    """One table of a document; ``where`` is its place in words, as errors name it: ``[model]``.

    Every reader raises InputError, naming place and key, for a missing key or a wrong value. A reader
    given ``default`` returns that where the key is absent. ``close`` reports keys that nothing has read.
    """

    _REQUIRED: Any = object()

    def __init__(self, data: Mapping[str, Any], where: str = "") -> None:
        self._data = data
        self._where = where
        self._read: list[str] = []

    def name(self, key: str) -> str:
        """Return the key with its place, as errors name it."""
        return f"{self._where} {key}".lstrip()

    def has(self, key: str) -> bool:
        """Say whether the key is there."""
        return key in self._data

    def get(self, key: str, default: Any = _REQUIRED) -> Any:
        """Return a value as it stands."""
        self._read.append(key)
        if key in self._data:
            return self._data[key]
        if default is Section._REQUIRED:
            unread = [k for k in self._data if k not in self._read]
            like = difflib.get_close_matches(key, unread, 1)
            hint = f"; is {_show_key(like[0])} meant for it?" if like else ""
            raise InputError(f"{self.name(key)} is missing{hint}")
        return default

    def number(self, key: str, default: Any = _REQUIRED, at_least: float = -math.inf) -> Any:
        """Return a finite number as a float."""
        value = self.get(key, default)
        return value if value is default else self._number(key, value, at_least)

    def number_within(self, key: str, limits: tuple[float, float], default: Any = _REQUIRED) -> Any:
        """Return a finite number that lies within ``limits``, least and most."""
        value = self.number(key, default)
        least, most = limits
        if not least <= value <= most:
            raise InputError(f"{self.name(key)} is {value:g}; it must be {least:g} to {most:g}")
        return value

    def integer(self, key: str, default: Any = _REQUIRED, at_least: int = 0) -> Any:
        """Return a whole number."""
        value = self.get(key, default)
        if value is default:
            return value
        if type(value) is not int or value < at_least:
            raise InputError(
                f"{self.name(key)} is {_show(value)}; it must be a whole number, {at_least} or more"
            )
        return value

    def flag(self, key: str, default: Any = _REQUIRED) -> Any:
        """Return true or false."""
        return self._typed(key, default, bool, "true or false")

    def text(self, key: str, default: Any = _REQUIRED) -> Any:
        """Return a string."""
        return self._typed(key, default, str, "a string")

    def choice(self, key: str, choices: tuple[str, ...]) -> str:
        """Return one of the given words."""
        value = self.get(key)
        if value not in choices:
            raise InputError(f"{self.name(key)} is {_show(value)}; it must be {_either(choices)}")
        return str(value)

    def pair(self, key: str, at_least: float = -math.inf) -> tuple[float, float]:
        """Return two finite numbers: a point (x, y) or its uncertainty."""
        value = self.get(key)
        if not isinstance(value, list) or len(value) != 2:
            raise InputError(f"{self.name(key)} is {_show(value)}; it must be two numbers [x, y]")
        x, y = (self._number(f"{key}[{i}]", v, at_least) for i, v in enumerate(value))
        return x, y

    def size(self, key: str) -> tuple[int, int]:
        """Return a frame size (width, height) in whole pixels."""
        value = self.get(key)
        if (
            not isinstance(value, list)
            or len(value) != 2
            or any(type(v) is not int or v < 1 for v in value)
        ):
            raise InputError(
                f"{self.name(key)} is {_show(value)}; it must be [width, height] in whole pixels"
            )
        return value[0], value[1]

    def texts(self, key: str) -> tuple[str, ...]:
        """Return a list of strings; an absent one is empty."""
        value = self.get(key, [])
        if not isinstance(value, list) or not all(isinstance(v, str) for v in value):
            raise InputError(f"{self.name(key)} is {_show(value)}; it must be a list of strings")
        return tuple(value)

    def section(self, key: str, where: str | None = None) -> Section:
        """Return a table inside this one."""
        value = self.get(key)
        if not isinstance(value, dict):
            raise InputError(f"{self.name(key)} is {_show(value)}; it must be a table")
        return Section(value, where or self.name(f"[{key}]"))

    def sections(self, key: str, label: str) -> list[Section]:
        """Return a list of tables; an absent one is empty. Errors name the second one ``label 2``."""
        value = self.get(key, [])
        if not isinstance(value, list) or not all(isinstance(v, dict) for v in value):
            raise InputError(f"{self.name(key)} is {_show(value)}; it must be a list of tables")
        return [Section(v, f"{label} {i}:") for i, v in enumerate(value, 1)]

    def close(self) -> None:
        """Raise InputError naming the keys that nothing has asked for."""
        unknown = [k for k in self._data if k not in self._read]
        if not unknown:
            return
        hint = ""
        close = difflib.get_close_matches(unknown[0], self._read, 1)
        if len(unknown) == 1 and close:
            hint = f"; did you mean {close[0]}?"
        names = ", ".join(self.name(_show_key(k)) for k in unknown[:8])
        plural = "s" if len(unknown) > 1 else ""
        raise InputError(f"unknown key{plural} {names}{hint}")

    def _number(self, key: str, value: Any, at_least: float) -> float:
        if type(value) not in (int, float):
            raise InputError(f"{self.name(key)} is {_show(value)}; it must be a number")
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise InputError(f"{self.name(key)} is {_show(value)}; it must be a finite number")
        if number < at_least:
            raise InputError(f"{self.name(key)} is {number:g}; it must be {at_least:g} or more")
        return number

    def _typed(self, key: str, default: Any, kind: type, words: str) -> Any:
        value = self.get(key, default)
        if value is not default and not isinstance(value, kind):
            raise InputError(f"{self.name(key)} is {_show(value)}; it must be {words}")
        return value


def _either(words: tuple[str, ...]) -> str:
    quoted = [f'"{w}"' for w in words]
    return quoted[0] if len(quoted) == 1 else f"{', '.join(quoted[:-1])} or {quoted[-1]}"


def _show(value: Any) -> str:
    """Return a value as an error quotes it: on one line, and short."""
    if isinstance(value, dict):
        return "a table"
    try:
        text = repr(value)
    except ValueError:  # an integer too long for Python to print
        text = "a very long number"
    return text if len(text) <= 40 else text[:37] + "..."


def _show_key(key: str) -> str:
    return key if key.isidentifier() and len(key) <= 40 else _show(key)
