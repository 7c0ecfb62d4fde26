"""The zoom of each frame as a file: CSV or JSON lines, by the name's suffix."""

from __future__ import annotations

import contextlib
import csv
import json
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, TextIO

import numpy as np

from ..errors import InputError, UsageError
from ..files import atomic_output
from ..files.names import shown
from ..model import DivisionModel

COLUMNS = ("frame", "time", "diameter", "source", "lambda", "center_x", "center_y", "uncertainty")
_CSV, _LINES = (".csv",), (".jsonl", ".ndjson", ".json")


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


class RecordedZoom:
    """The diameter over time from a log, interpolated between its rows and held at its ends.

    Rows count by their time or, where a row has none, all of them by their frame number. Raises InputError
    for a file that is missing or empty, or whose rows lack a diameter.
    """

    def __init__(self, path: str) -> None:
        self._name = shown(path)
        rows = list(self._rows(path))
        if not rows:
            raise InputError(f"{self._name}: holds no row with a diameter")
        self.by_time = all(time is not None for _, time, _ in rows)
        places = [time if self.by_time else frame for frame, time, _ in rows]
        if any(place is None for place in places):
            raise InputError(f"{self._name}: every row needs a time or a frame number")
        order = np.argsort(np.array(places, float), kind="stable")
        self._places = np.array(places, float)[order]
        # A zoom is a ratio, so that it is interpolated in the logarithm.
        self._logs = np.log([diameter for _, _, diameter in rows])[order]

    def diameter(self, frame: int, time: float | None) -> float:
        """Return the diameter, px, for a frame by its number and time in s."""
        if self.by_time and time is None:
            raise InputError(f"{self._name}: gives times, but the video's frames have none")
        place = time if self.by_time else frame
        return float(np.exp(np.interp(float(place or 0), self._places, self._logs)))

    def _rows(self, path: str) -> Iterator[tuple[int | None, float | None, float]]:
        is_csv = _is_csv(path)
        try:
            with Path(path).open(encoding="utf-8", newline="") as file:
                rows: Iterable[Any] = csv.DictReader(file) if is_csv else map(_parse, file)
                for number, row in enumerate(rows, 2 if is_csv else 1):
                    if row is None:
                        continue
                    yield self._row(row, number)
        except OSError as error:
            raise InputError(f"{self._name}: {error.strerror}") from None
        except UnicodeDecodeError:
            raise InputError(f"{self._name}: is no text file") from None

    def _row(self, row: Any, line: int) -> tuple[int | None, float | None, float]:
        try:
            diameter = float(row["diameter"])
            frame, time = (row.get(key) for key in ("frame", "time"))
            place = (
                None if frame in (None, "") else int(frame),
                None if time in (None, "") else float(time),
            )
        except (KeyError, TypeError, ValueError, AttributeError):
            raise InputError(
                f"{self._name}, line {line}: needs a diameter in px, and a frame or a time in s"
            ) from None
        if not (math.isfinite(diameter) and diameter > 0):
            raise InputError(
                f"{self._name}, line {line}: the diameter {diameter:g} is not a positive number"
            )
        return *place, diameter


def _is_csv(path: str) -> bool:
    suffix = Path(path).suffix.lower()
    if suffix not in (*_CSV, *_LINES):
        raise UsageError(f"{shown(path)}: a zoom log is .csv or .jsonl")
    return suffix in _CSV


def _parse(line: str) -> Any:
    """Parse one JSON line; None for an empty one, and a string, which no row is, for any other text."""
    try:
        return json.loads(line) if line.strip() else None
    except ValueError:
        return line
