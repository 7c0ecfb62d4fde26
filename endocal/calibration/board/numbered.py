"""The lines of boards that have their place in a regular grid: a chessboard's, or parallel bars'."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..measure.profiles import Measured
from ..straightness import Floats, Labels
from .bars import bars_of
from .lattice import numbers_of
from .pattern import crossings_of

# A chessboard's grid is looked for where so many of its rows and so many of its columns are numbered, and
# that of bars where so many rows of ends are seen: one alone tells nothing.
FEWEST_NUMBERED = 4
FEWEST_ROWS = 2


@dataclass(frozen=True)
class Numbered:
    """Lines that are known on a board: their labels ``line`` (n,), ``board``, ``family`` and ``number``.

    Those of one family run alike. Of a line that is not ``placed`` (n,) only the family is known.
    """

    line: Labels
    board: Labels
    family: Labels
    number: Floats
    placed: NDArray[np.bool_]


def numbered_lines(measured: Measured, view: Labels, params: Floats) -> Numbered:
    """Return the lines of each view that have a place, where a view shows enough of them.

    ``view`` (n,) tells which view each point is from; the lines are straight under ``params``. Boards are
    numbered from 0.
    """
    parts: list[Numbered] = []
    for own in (view == v for v in np.unique(view)):
        part = measured.take(own)
        found = _chessboard(part, len(parts)) or _bars(part, params, len(parts))
        if found is not None:
            # With the labels that lines have in all views.
            labels = np.unique(measured.labels[own])
            parts.append(replace(found, line=labels[found.line]))
    if not parts:
        none = np.empty(0, np.intp)
        return Numbered(none, none, none, np.empty(0), np.empty(0, bool))
    columns = zip(*((p.line, p.board, p.family, p.number, p.placed) for p in parts), strict=True)
    return Numbered(*(np.concatenate(c) for c in columns))


def _chessboard(measured: Measured, board: int) -> Numbered | None:
    count = int(measured.labels.max()) + 1
    family, number = numbers_of(crossings_of(measured), count)
    if min(np.count_nonzero(family == f) for f in (0, 1)) < FEWEST_NUMBERED:
        return None
    line = np.flatnonzero(family >= 0)
    n = len(line)
    places = number[line].astype(np.float64)
    return Numbered(line, np.full(n, board), family[line], places, np.ones(n, bool))


def _bars(measured: Measured, params: Floats, board: int) -> Numbered | None:
    bars = bars_of(measured, params)
    if bars is None or len(bars.rows) < FEWEST_ROWS:
        return None
    line = np.append(bars.edges, bars.rows)
    across = np.arange(len(line)) >= len(bars.edges)
    number = np.zeros(len(line))
    number[: len(bars.edges)] = bars.numbers
    return Numbered(line, np.full(len(line), board), across.astype(np.intp), number, ~across)
