"""The zoom of each frame as a file: CSV or JSON lines, by the name's suffix."""

from __future__ import annotations

import contextlib
import csv
import json
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
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
COLUMNS = ("frame", "time", "diameter", "source", "lambda", "center_x", "center_y", "uncertainty")
_CSV, _LINES = (".csv",), (".jsonl", ".ndjson", ".json")
LOG_SUFFIXES = (*_CSV, *_LINES)


@dataclass(frozen=True)
class ZoomRecord:
    """The zoom of one frame.

    ``time`` in s (None: not known); ``diameter`` of the visible circle in px; ``source`` is rim, tracked,
    held or given; ``uncertainty`` is one relative standard deviation of the diameter.
    """

    frame: int
    time: float | None
    diameter: float
    source: str
    model: DivisionModel
    uncertainty: float

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
            "uncertainty": float(f"{self.uncertainty:.3g}"),
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
    """One row of a log: what it must hold, and what it may (NaN or "" where it does not)."""

    frame: int | None
    time: float | None
    diameter: float
    source: str
    lam: float
    uncertainty: float


class RecordedZoom:
    """The diameter over time from a log, interpolated between its rows and held at its ends.

    Rows count by their time or, where a row has none, all of them by their frame number. Raises InputError
    for a file that is missing or empty, or whose rows lack a diameter.
    """

    def __init__(self, path: str) -> None:
        self._name = shown(path)
        rows = list(recorded_rows(path))
        self.by_time, places = places_of(rows, self._name)
        order = np.argsort(places, kind="stable")
        self._places = places[order]
        # A zoom is a ratio, so that it is interpolated in the logarithm.
        self._logs = np.log([row.diameter for row in rows])[order]

    def diameter(self, frame: int, time: float | None) -> float:
        """Return the diameter, px, for a frame by its number and time in s."""
        if self.by_time and time is None:
            raise InputError(f"{self._name}: gives times, but the video's frames have none")
        place = time if self.by_time else frame
        return float(np.exp(np.interp(float(place or 0), self._places, self._logs)))


def places_of(rows: Sequence[RecordedRow], name: str) -> tuple[bool, NDArray[np.float64]]:
    """Return whether rows count by time, and the time in s or the frame number of each.

    Raises InputError, calling the log ``name``, where there is no row, or one has neither.
    """
    if not rows:
        raise InputError(f"{name}: holds no row with a diameter")
    by_time = all(row.time is not None for row in rows)
    places = [row.time if by_time else row.frame for row in rows]
    if any(place is None for place in places):
        raise InputError(f"{name}: every row needs a time or a frame number")
    return by_time, np.array(places, np.float64)


def recorded_rows(path: str) -> Iterator[RecordedRow]:
    """Yield the rows of a log as they come; InputError for a file or a row that is none."""
    is_csv, name = _is_csv(path), shown(path)
    try:
        with Path(path).open(encoding="utf-8", newline="") as file:
            rows: Iterable[Any] = csv.DictReader(file) if is_csv else map(_parse, file)
            for number, row in enumerate(rows, 2 if is_csv else 1):
                if row is not None:
                    yield _row(row, f"{name}, line {number}")
    except OSError as error:
        raise InputError(f"{name}: {error.strerror}") from None
    except UnicodeDecodeError:
        raise InputError(f"{name}: is no text file") from None


def _row(row: Any, where: str) -> RecordedRow:
    try:
        diameter = float(row["diameter"])
        frame, time = (row.get(key) for key in ("frame", "time"))
        place = (
            None if frame in (None, "") else int(frame),
            None if time in (None, "") else float(time),
        )
    except (KeyError, TypeError, ValueError, AttributeError):
        raise InputError(f"{where}: needs a diameter in px, and a frame or a time in s") from None
    if not (math.isfinite(diameter) and 0 < diameter < WIDEST_CIRCLE):
        raise InputError(f"{where}: the diameter {diameter:g} px is that of no circle")
    source = row.get("source")
    return RecordedRow(
        *place,
        diameter,
        source if isinstance(source, str) else "",
        _number(row.get("lambda")),
        _number(row.get("uncertainty")),
    )


def _number(value: Any) -> float:
    """Return what need not be there as a number; NaN where it is none."""
    try:
        return float(value)
    except (TypeError, ValueError):
        return math.nan


def _is_csv(path: str) -> bool:
    suffix = Path(path).suffix.lower()
    if suffix not in LOG_SUFFIXES:
        raise UsageError(f"{shown(path)}: a zoom log is .csv or .jsonl")
    return suffix in _CSV


def _parse(line: str) -> Any:
    """Parse one JSON line; None for an empty one, and a string, which no row is, for any other text."""
    try:
        return json.loads(line) if line.strip() else None
    except ValueError:
        return line
