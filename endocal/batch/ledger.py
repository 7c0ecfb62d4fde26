"""The ledger: what a batch has done, kept so that nothing is lost and nothing done twice."""

from __future__ import annotations

import json
import os
import secrets
import sqlite3
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import InputError, OutputError
from ..files.names import shown
from .fingerprint import FileState
from .recording import Recording

VERSION = 1
NAME = "ledger.sqlite"
# "endc", so that a file of another program is told apart.
_APPLICATION = 0x656E6463

RUNNING, DONE, FAILED = "running", "done", "failed"

_SCHEMA = """
CREATE TABLE about (key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE recording (
    place TEXT PRIMARY KEY,      -- the output, below the directory of outputs
    source TEXT NOT NULL,        -- the input's absolute path
    status TEXT NOT NULL,        -- running, done or failed
    error TEXT,                  -- why it failed, in one line
    began TEXT NOT NULL,         -- UTC
    ended TEXT,
    -- what the output was made from; of a recording that is running or failed, the last one that was done
    input_sha256 TEXT,
    input_size INTEGER,
    input_mtime_ns INTEGER,
    input_ctime_ns INTEGER,
    input_inode INTEGER,
    input_settled INTEGER,       -- 1: the times above tell of every later change
    lens_sha256 TEXT,            -- of the calibration's bytes
    options_sha256 TEXT,
    endocal TEXT,                -- the version that made it
    output_sha256 TEXT,
    output_size INTEGER,
    report TEXT                  -- JSON
) WITHOUT ROWID;
"""


@dataclass(frozen=True)
class Made:
    """What an output was made from, what it is, and the report of its making."""

    input_sha256: str
    input_state: FileState
    input_settled: bool
    lens_sha256: str
    options_sha256: str
    endocal: str
    output_sha256: str
    output_size: int
    report: dict[str, Any]


@dataclass(frozen=True)
class Entry:
    """A recording in the ledger; ``made`` tells of its output, if there ever was one."""

    place: str
    source: str
    status: str
    error: str | None
    made: Made | None


class Ledger:
    """An SQLite file, written by the one batch that holds the lock and read by anybody.

    A rollback journal rather than a write-ahead log, since the latter needs memory that all readers share,
    which a network drive has not. Every change is on the disk when its method returns.
    """

    def __init__(self, path: Path, connection: sqlite3.Connection) -> None:
        self._path = path
        self._connection = connection

    @property
    def mark(self) -> str:
        """A name for this ledger's temporary files, its own."""
        return str(self.about("mark"))

    def about(self, key: str) -> str | None:
        """Return a fact about the ledger."""
        row = self._connection.execute("SELECT value FROM about WHERE key = ?", (key,)).fetchone()
        return None if row is None else str(row[0])

    def note(self, key: str, value: str) -> None:
        """Keep a fact about the ledger."""
        self._write("INSERT OR REPLACE INTO about VALUES (?, ?)", (key, _printable(value)))

    def entries(self) -> dict[str, Entry]:
        """Return all recordings by their places."""
        rows = self._connection.execute("SELECT * FROM recording")
        columns = [c[0] for c in rows.description]
        entries = (_entry(dict(zip(columns, row, strict=True))) for row in rows)
        return {entry.place: entry for entry in entries}

    def begin(self, recording: Recording) -> None:
        """Record that a recording is handed out: an output that appears from now on is ours."""
        self._write(
            "INSERT INTO recording (place, source, status, began) VALUES (?, ?, ?, ?)"
            " ON CONFLICT (place) DO UPDATE SET source = excluded.source, status = excluded.status,"
            " began = excluded.began, ended = NULL, error = NULL",
            (_storable(recording.place), _storable(recording.source), RUNNING, _now()),
        )

    def fail(self, place: str, error: str) -> None:
        """Record that a recording failed."""
        self._write(
            "UPDATE recording SET status = ?, error = ?, ended = ? WHERE place = ?",
            (FAILED, _printable(error), _now(), _storable(place)),
        )

    def finish(self, place: str, made: Made) -> None:
        """Record that a recording is done."""
        state = made.input_state
        self._write(
            "UPDATE recording SET status = ?, error = NULL, ended = ?, input_sha256 = ?, input_size = ?,"
            " input_mtime_ns = ?, input_ctime_ns = ?, input_inode = ?, input_settled = ?,"
            " lens_sha256 = ?, options_sha256 = ?, endocal = ?, output_sha256 = ?, output_size = ?,"
            " report = ? WHERE place = ?",
            (
                *(DONE, _now(), made.input_sha256, state.size, state.mtime_ns, state.ctime_ns),
                *(_signed(state.inode), made.input_settled, made.lens_sha256, made.options_sha256),
                *(made.endocal, made.output_sha256, made.output_size, json.dumps(made.report)),
                _storable(place),
            ),
        )

    def _write(self, statement: str, values: tuple[Any, ...]) -> None:
        with self._refusals():
            self._connection.execute(statement, values)

    @contextmanager
    def _refusals(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.Error as error:
            raise OutputError(f"{shown(self._path)}: cannot be written: {error}") from error


@contextmanager
def open_ledger(path: Path, read_only: bool = False) -> Iterator[Ledger]:
    """Open the ledger, and make it where it is not there and not ``read_only``.

    Raises InputError for a file that is no ledger, is damaged, or comes from a newer version.
    """
    uri = f"{path.absolute().as_uri()}?mode={'ro' if read_only else 'rwc'}"
    try:
        connection = sqlite3.connect(uri, uri=True, timeout=30, isolation_level=None)
    except sqlite3.Error as error:
        raise OutputError(f"{shown(path)}: cannot be opened: {error}") from None
    try:
        _prepare(connection, path, read_only)
        yield Ledger(path, connection)
    finally:
        connection.close()


def _prepare(connection: sqlite3.Connection, path: Path, read_only: bool) -> None:
    """Check that the file is a ledger that we know; make it one where it is empty."""
    try:
        connection.execute("PRAGMA synchronous = FULL")
        version, application, pages = (
            connection.execute(f"PRAGMA {name}").fetchone()[0]
            for name in ("user_version", "application_id", "page_count")
        )
        if pages == 0 and not read_only:
            connection.executescript(
                f"BEGIN; {_SCHEMA} PRAGMA user_version = {VERSION}; PRAGMA application_id = {_APPLICATION};"
                f" INSERT INTO about VALUES ('mark', '{secrets.token_hex(4)}'); COMMIT;"
            )
            return
        # Damage shows here rather than in the middle of the night.
        sound = connection.execute("PRAGMA quick_check(1)").fetchone()[0]
    except sqlite3.OperationalError as error:
        raise OutputError(f"{shown(path)}: cannot be used: {error}") from None
    except sqlite3.DatabaseError as error:
        raise InputError(f"{shown(path)}: {error}: {_ADVICE}") from None
    if application != _APPLICATION:
        raise InputError(f"{shown(path)}: is no ledger of endocal: {_ADVICE}")
    if version > VERSION:
        raise InputError(
            f"{shown(path)}: was made by a newer endocal (schema {version}): update endocal"
        )
    if sound != "ok":
        raise InputError(f"{shown(path)}: is damaged ({sound}): {_ADVICE}")


_ADVICE = "put it aside, and give --overwrite once to make the outputs anew"


def _entry(row: dict[str, Any]) -> Entry:
    made = None
    if row["output_sha256"] is not None:
        state = FileState(
            row["input_size"],
            row["input_mtime_ns"],
            row["input_ctime_ns"],
            row["input_inode"] % (1 << 64),
        )
        made = Made(
            row["input_sha256"],
            state,
            bool(row["input_settled"]),
            row["lens_sha256"],
            row["options_sha256"],
            row["endocal"],
            row["output_sha256"],
            row["output_size"],
            json.loads(row["report"]),
        )
    place, source = (os.fsdecode(row[key]) for key in ("place", "source"))
    return Entry(place, source, row["status"], row["error"], made)


def _now() -> str:
    return time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())


def _storable(path: str) -> str | bytes:
    """Return a path as SQLite takes it: as text, or as bytes where it is no Unicode."""
    try:
        path.encode()
    except UnicodeEncodeError:
        return os.fsencode(path)
    return path


def _printable(text: str) -> str:
    return text.encode(errors="backslashreplace").decode()


def _signed(value: int) -> int:
    """Return an unsigned number of 64 bits as the signed one that SQLite stores."""
    return value - (1 << 64) if value >= 1 << 63 else value
