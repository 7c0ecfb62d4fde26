"""Patterns of file names: what they match, and where a scope's serial number stands in a match."""

from __future__ import annotations

import fnmatch
import glob
import os
import re
from collections.abc import Iterable

from ..errors import InputError
from ..files.names import shown

# Stands in a pattern for the scope's serial number, and in a calibration's name for the one found there.
SERIAL = "{serial}"
_WILDCARDS = {"**/": "(?:.*/)?", "**": ".*", "*": "[^/]*", "?": "[^/]"}


def fixed_part(pattern: str, folder: str = ".") -> str:
    """Return the directory that a pattern's wildcards begin below, as the pattern writes it.

    A directory that is there by its very name is taken for that: brackets in its name are no wildcards.
    """
    parts = pattern.split(os.sep)
    fixed = ""
    for part in parts[:-1]:
        further = os.path.join(fixed, part or os.sep) if part or not fixed else fixed
        magic = glob.has_magic(part) or SERIAL in part
        if magic and not os.path.isdir(os.path.join(folder, further)):
            break
        fixed = further
    return fixed or "."


def matches(pattern: str, folder: str = ".") -> list[str]:
    """Return the files that a pattern matches, sorted, as paths from ``folder`` on; no directories.

    ``{serial}`` stands for one character or more.
    """
    fixed = fixed_part(pattern, folder)
    # Two stars side by side would go into directories.
    rest = os.path.relpath(pattern, fixed).replace(SERIAL, "?*")
    whole = os.path.join(folder, fixed)
    found = (os.path.join(fixed, p) for p in glob.iglob(rest, root_dir=whole, recursive=True))
    return sorted(os.path.normpath(p) for p in found if not os.path.isdir(os.path.join(folder, p)))


def serial_in(path: str, pattern: str, known: Iterable[str], folder: str = ".") -> str:
    """Return the serial number that stands in a path where the pattern has ``{serial}``.

    A known number goes before any other, and before one that is part of it. Raises InputError where known
    ones stand at several places that the pattern allows: which of them is meant, it does not tell.
    """
    fixed = fixed_part(pattern, folder)
    path, pattern = os.path.relpath(path, fixed), os.path.relpath(pattern, fixed)
    before, _, after = pattern.partition(SERIAL)
    ahead = re.compile(_expression(before))
    spans: list[tuple[int, int]] = []
    for serial in filter(None, set(known)):
        behind = re.compile(_expression(after.replace(SERIAL, glob.escape(serial))))
        for place in re.finditer(f"(?={re.escape(serial)})", path):
            start, end = place.start(), place.start() + len(serial)
            if ahead.fullmatch(path[:start]) and behind.fullmatch(path[end:]):
                spans.append((start, end))
    whole = [s for s in spans if not any(o != s and o[0] <= s[0] and s[1] <= o[1] for o in spans)]
    serials = sorted({path[start:end] for start, end in whole})
    if len(serials) > 1:
        raise InputError(
            f"{shown(path)}: {pattern!r} finds the serial numbers {' and '.join(map(repr, serials))}: give"
            " the one that is meant with serial, or write more of the name in files"
        )
    if serials:
        return serials[0]
    expression = f"{_expression(before)}(?P<serial>[^/]+?){_expression(after, named=True)}"
    if match := re.fullmatch(expression, path):
        return match["serial"]
    raise InputError(f"{shown(path)}: no serial number is found by {pattern!r}")


def _expression(pattern: str, named: bool = False) -> str:
    """Turn a pattern of glob's into a regular expression; ``named``: {serial} is the group's text again."""
    out = []
    for part in re.split(r"(\*\*/|\*\*|\*|\?|\[!?\]?[^\]]*\]|\{serial\})", pattern):
        if part == SERIAL and named:
            out.append("(?P=serial)")
        elif part.startswith("[") and part.endswith("]"):
            # As glob takes it, ranges that run backwards too; without the mark of the end.
            out.append(fnmatch.translate(part)[:-2])
        else:
            out.append(_WILDCARDS.get(part) or re.escape(part))
    return "(?s:" + "".join(out) + ")"
