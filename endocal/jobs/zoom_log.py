"""The zoom of each frame as a file: CSV or JSON lines, by the name's suffix."""

from __future__ import annotations

import contextlib
import csv
import json
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple, Protocol, TextIO

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, UsageError
from ..files import atomic_output
from ..files.names import shown
from ..model import DivisionModel

# No circle that a log tells of is wider than this, px: frames are at most 16384 px wide.
WIDEST_CIRCLE = 1e6
# No recording goes on to a frame or a second of this number, which floats count exactly.
_FURTHEST = 2**53
# Diameters of one instant that differ by more than a log's rounding, relative, contradict each other.
_SAME_DIAMETER = 1e-4
_SHIFT = ("shift_x", "shift_y")
COLUMNS = (
    *("frame", "time", "diameter", "source", "lambda", "center_x", "center_y", "uncertainty"),
    *_SHIFT,
)
_CSV, _LINES = (".csv",), (".jsonl", ".ndjson", ".json")
LOG_SUFFIXES = (*_CSV, *_LINES)


@dataclass(frozen=True)
class ZoomRecord:
    """The zoom of one frame.

    ``time`` in s (None: not known); ``diameter`` of the visible circle in px; ``source`` is rim, tracked,
    held or given; ``uncertainty`` is one relative standard deviation of the diameter (NaN: not known).
    ``shift`` (x, y) px is how far the model's centre lies from the table's, as the circle does.
    """

    frame: int
    time: float | None
    diameter: float
    source: str
    model: DivisionModel
    uncertainty: float
    shift: tuple[float, float] = (0.0, 0.0)

    def row(self) -> dict[str, Any]:
        """Return the values by COLUMNS, rounded below what can be measured."""
        return {
            "frame": self.frame,
            "time": None if self.time is None else round(self.time, 6),
            "diameter": round(self.diameter, 3),
            "source": self.source,
            "lambda": float(f"{self.model.lam:.7g}"),
            "center_x": round(self.model.center[0], 3),
            "center_y": round(self.model.center[1], 3),
            "uncertainty": (
                None if math.isnan(self.uncertainty) else float(f"{self.uncertainty:.3g}")
            ),
            # No negative zeros.
            **{name: round(v, 3) + 0.0 for name, v in zip(_SHIFT, self.shift, strict=True)},
        }


class ZoomLog(Protocol):
    """Takes the records of the frames in order."""

    def add(self, record: ZoomRecord) -> None:
        """Write one record."""
        ...


class _Csv:
    def __init__(self, file: TextIO) -> None:
        self._rows = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        self._rows.writeheader()

    def add(self, record: ZoomRecord) -> None:
        self._rows.writerow(record.row())


class _Lines:
    def __init__(self, file: TextIO) -> None:
        self._file = file

    def add(self, record: ZoomRecord) -> None:
        self._file.write(json.dumps(record.row()) + "\n")


@contextlib.contextmanager
def zoom_log(path: str, overwrite: bool, inputs: Iterable[str]) -> Iterator[ZoomLog]:
    """Open a log that takes its name when the block ends well; see ``atomic_output`` for what it raises."""
    kind = _Csv if _is_csv(path) else _Lines
    with (
        atomic_output(path, overwrite=overwrite, inputs=inputs) as temporary,
        temporary.open("w", encoding="utf-8", newline="") as file,
    ):
        yield kind(file)


class RecordedRow(NamedTuple):
    """One row of a log: its line, what it must hold, and what it may (NaN or "" where it does not)."""

    line: int
    frame: int | None
    time: float | None
    diameter: float
    source: str
    lam: float
    uncertainty: float
    shift: tuple[float, float]


class RecordedZoom:
    """What a log, called ``name``, tells over time: diameter, its uncertainty, circle's shift; its ``rows``.

    They are interpolated between its rows and held at its ends. Rows count by their time or, where none has
    one, by their frame number. Raises InputError for a file that is missing or empty, whose rows lack a
    diameter, or where two of one instant contradict each other.
    """

    def __init__(self, path: str) -> None:
        self.name = shown(path)
        rows = list(recorded_rows(path))
        self.by_time, places = places_of(rows, self.name)
        order = np.argsort(places, kind="stable")
        self._places = places[order]
        self.rows = tuple(rows[i] for i in order)
        # A zoom is a ratio, so that it is interpolated in the logarithm.
        self._logs = np.log([row.diameter for row in self.rows])
        self._shifts = np.array([row.shift for row in self.rows])
        stated = np.array([row.uncertainty for row in self.rows])
        self._uncertainties = np.where(np.isfinite(stated) & (stated >= 0), stated, np.nan)
        self._check_instants()

    def _check_instants(self) -> None:
        """Refuse two diameters of one instant; frames of their own may share it, in a damaged recording."""
        for a, b in pairwise(self.rows):
            if a.frame != b.frame or (self.by_time and a.time != b.time):
                continue
            if abs(math.log(b.diameter / a.diameter)) > _SAME_DIAMETER:
                instant = f"{b.time:g} s" if self.by_time else f"frame {b.frame}"
                raise InputError(
                    f"{self.name}, line {b.line}: says {b.diameter:g} px of {instant}, where line {a.line}"
                    f" says {a.diameter:g} px: leave one out"
                )

    def diameter(self, frame: int, time: float | None) -> float:
        """Return the diameter, px, for a frame by its number and time in s."""
        return float(np.exp(np.interp(self._place(frame, time), self._places, self._logs)))

    def uncertainty(self, frame: int, time: float | None) -> float:
        """Return the diameter's relative standard deviation likewise; NaN where the log does not tell it."""
        return float(np.interp(self._place(frame, time), self._places, self._uncertainties))

    def shift(self, frame: int, time: float | None) -> tuple[float, float]:
        """Return the circle's shift (x, y), px, likewise; none where the log does not tell it."""
        place = self._place(frame, time)
        x, y = (float(np.interp(place, self._places, shift)) for shift in self._shifts.T)
        return x, y

    def _place(self, frame: int, time: float | None) -> float:
        if self.by_time and time is None:
            raise InputError(f"{self.name}: gives times, but the video's frames have none")
        return float((time if self.by_time else frame) or 0)


def places_of(rows: Sequence[RecordedRow], name: str) -> tuple[bool, NDArray[np.float64]]:
    """Return whether rows count by time, and the time in s or the frame number of each.

    Raises InputError, calling the log ``name``, where there is no row, one has neither, or some have a time
    and others do not.
    """
    if not rows:
        raise InputError(f"{name}: holds no row with a diameter")
    by_time = any(row.time is not None for row in rows)
    places = [row.time if by_time else row.frame for row in rows]
    if None in places:
        line = rows[places.index(None)].line
        raise InputError(
            f"{name}, line {line}: has no time, where other rows have one"
            if by_time
            else f"{name}, line {line}: every row needs a time or a frame number"
        )
    return by_time, np.array(places, np.float64)


def recorded_rows(path: str) -> Iterator[RecordedRow]:
    """Yield the rows of a log as they come; InputError for a file or a row that is none."""
    is_csv, name = _is_csv(path), shown(path)
    try:
        # Spreadsheets put a byte-order mark before the first column's name.
        with Path(path).open(encoding="utf-8-sig", newline="") as file:
            for line, row in _csv_rows(file, name) if is_csv else _line_rows(file):
                yield _row(row, line, f"{name}, line {line}")
    except OSError as error:
        raise InputError(f"{name}: {error.strerror}") from None
    except UnicodeDecodeError:
        raise InputError(f"{name}: is no text file") from None


def _csv_rows(file: TextIO, name: str) -> Iterator[tuple[int, Any]]:
    rows = csv.DictReader(file)
    try:
        for row in rows:
            yield rows.line_num, row
    except csv.Error as error:
        # The reader counts a line once it is through with it.
        raise InputError(f"{name}, line {rows.line_num + 1}: is no CSV ({error})") from None


def _line_rows(file: TextIO) -> Iterator[tuple[int, Any]]:
    """Parse the lines that are not empty; text that is no JSON stays a string, which no row is."""
    for number, line in enumerate(file, 1):
        if not line.strip():
            continue
        try:
            yield number, json.loads(line)
        except (ValueError, RecursionError):
            yield number, line


def _row(row: Any, line: int, where: str) -> RecordedRow:
    try:
        diameter, frame, time = (_stated(row.get(key)) for key in ("diameter", "frame", "time"))
    except (TypeError, ValueError, AttributeError):
        diameter = None
    if diameter is None:
        raise InputError(f"{where}: needs a diameter in px, and a frame or a time in s")
    if not 0 < diameter < WIDEST_CIRCLE:
        raise InputError(f"{where}: the diameter {diameter:g} px is that of no circle")
    if time is not None and not abs(time) < _FURTHEST:
        raise InputError(f"{where}: the time {time:g} s is that of no frame")
    if frame is not None and not (abs(frame) < _FURTHEST and frame.is_integer()):
        raise InputError(f"{where}: the frame {frame:g} is no whole number of one")
    shift = [_number(row.get(name) or 0.0) for name in _SHIFT]
    if not all(abs(v) < WIDEST_CIRCLE for v in shift):
        raise InputError(f"{where}: {' and '.join(_SHIFT)} are a circle's shift in px, or left out")
    source = row.get("source")
    return RecordedRow(
        line,
        None if frame is None else int(frame),
        time,
        diameter,
        source if isinstance(source, str) else "",
        _number(row.get("lambda")),
        _number(row.get("uncertainty")),
        (shift[0], shift[1]),
    )


def _stated(value: Any) -> float | None:
    """Return what a row must be right about as a number, infinite where it is too large for one.

    None where the row leaves it out; TypeError or ValueError where it is no number.
    """
    if value in (None, ""):
        return None
    if isinstance(value, bool):
        raise TypeError
    try:
        return float(value)
    except OverflowError:
        return math.inf


def _number(value: Any) -> float:
    """Return what need not be there as a number; NaN where it is none."""
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        return math.nan


def _is_csv(path: str) -> bool:
    suffix = Path(path).suffix.lower()
    if suffix not in LOG_SUFFIXES:
        raise UsageError(f"{shown(path)}: a zoom log is .csv or .jsonl")
    return suffix in _CSV
