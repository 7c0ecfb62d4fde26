"""Lines that somebody chose in a picture, as text.

A point a row, ``x y`` or ``x,y`` in px, (0, 0) being the centre of the top left pixel; an empty row ends a
line; what follows a ``#`` is a comment.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

from ..errors import InputError
from .names import NO_SUCH_FILE, PathLike, shown

Line = tuple[tuple[float, float], ...]


def read_lines(path: PathLike) -> tuple[Line, ...]:
    """Read lines, at least one, of three points or more each, from a file; ``-`` is stdin.

    Raises InputError, naming file and row, for anything else.
    """
    name = "<stdin>" if str(path) == "-" else shown(path)
    try:
        text = sys.stdin.read() if str(path) == "-" else Path(path).read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(f"{name}: is no text; write a point x y a row") from None
    except FileNotFoundError:
        raise InputError(f"{name}: {NO_SUCH_FILE}") from None
    except OSError as error:
        raise InputError(f"{name}: cannot be read: {error.strerror or error}") from None
    lines: list[Line] = []
    points: list[tuple[float, float]] = []
    for number, row in enumerate([*text.splitlines(), ""], 1):
        words = row.partition("#")[0].replace(",", " ").split()
        if words:
            points.append(_point(words, f"{name}: row {number}"))
        elif points and not row.strip():
            if len(points) < 3:
                raise InputError(
                    f"{name}: the line that ends before row {number} has {len(points)} points;"
                    " 3 or more are needed"
                )
            lines.append(tuple(points))
            points = []
    if not lines:
        raise InputError(f"{name}: holds no line; write a point x y a row")
    return tuple(lines)


def _point(words: list[str], where: str) -> tuple[float, float]:
    try:
        x, y = (float(word) for word in words)
    except ValueError:
        x = y = math.nan
    if not (math.isfinite(x) and math.isfinite(y)):
        quoted = " ".join(words)[:40]
        raise InputError(f"{where}: {quoted!r} is no point: write two numbers, x y, in px")
    return x, y
