"""Text into the values of options where a type's own constructor does it.

Typer hands every value to a general converter whose import and set-up take a tenth of a second; here only
what it alone can convert or refuse goes to it. A typer that converts in another way is left to do so.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, get_args

import typer

_INT = re.compile(r"[+-]?[0-9]{1,15}")
_FLOAT = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]{1,2})?")


def convert_plainly(command: Any, parent: Any = None) -> None:
    """Let the parameters of a command, and of those below it, convert what is plain by themselves."""
    context = typer.Context(command, parent=parent, **(command.context_settings or {}))
    for parameter in command.get_params(context):
        _leave_reading_to_the_job(parameter)
        own = getattr(parameter, "get_runtime_param", None)
        if own is not None and hasattr(parameter, "type_descriptor"):
            parameter.get_runtime_param = lambda own=own: _Converter(own)
    for child in getattr(command, "commands", {}).values():
        convert_plainly(child, context)


def _leave_reading_to_the_job(parameter: Any) -> None:
    """Let a file that may not be read through: it fails as one that is missing does, in the words of the job.

    To typer it is wrong usage; and it says the same of an output that is there, which nobody reads.
    """
    descriptor = getattr(parameter, "type_descriptor", None)
    kinds: tuple[Any, Any] = (
        getattr(parameter, "type", None),
        getattr(descriptor, "parameter_info", None),
    )
    for kind in kinds:
        if hasattr(kind, "readable"):
            kind.readable = False


class _Converter:
    """Takes the place of typer's converter of one parameter; ``own`` makes that one."""

    def __init__(self, own: Callable[[], Any]) -> None:
        self._own = own

    def coerce(self, value: Any, param: Any, ctx: Any) -> Any:
        """Return the value in the parameter's type; raises what typer does."""
        is_many = param.multiple or param.nargs == -1
        if value is None:
            return () if is_many else None
        kind, info = param.type_descriptor.annotation, param.type_descriptor.parameter_info
        if not (info.parser or info.exists or info.resolve_path or info.min or info.max):
            items = list(value) if is_many and isinstance(value, (list, tuple)) else [value]
            kinds = get_args(kind) or (kind,)
            plain = [_plain(item, kinds[0]) for item in items]
            if None not in plain:
                return plain if is_many else plain[0]
        return self._own().coerce(value, param=param, ctx=ctx)


def _plain(value: Any, kind: type) -> Any:
    """Return text as a value of its kind; None where that is not plain."""
    if isinstance(value, kind):
        return value
    if not isinstance(value, str):
        return None
    if kind is Path:
        return Path(value)
    if kind is int and _INT.fullmatch(value):
        return int(value)
    if kind is float and _FLOAT.fullmatch(value):
        return float(value)
    return None
