"""Calibrations and zoom tables in TOML: read with every value checked, written alike each time."""

from __future__ import annotations

import os
import re
import sys
import tomllib
from pathlib import Path
from types import ModuleType

from .._version import __version__
from ..calibration.result import Calibration
from ..errors import InputError
from ..zoom.table import ZoomTable
from . import calibration, zoomtable
from .atomic import atomic_output
from .names import NO_SUCH_FILE, PathLike, shown
from .section import Section

# A table of a thousand settings stays under this; a video given by mistake does not.
_MAX_BYTES = 4 << 20

_KINDS: dict[str, ModuleType] = {calibration.SCHEMA: calibration, zoomtable.SCHEMA: zoomtable}


def load(path: PathLike) -> Calibration | ZoomTable:
    """Read a calibration or a zoom table; ``-`` reads standard input.

    Raises InputError, naming file and key, for a file that is missing or unreadable, no TOML, of another
    or a newer schema, or that holds unknown keys or values that make no sound lens model.
    """
    if os.fspath(path) == "-":
        return loads(_decode(sys.stdin.buffer.read(_MAX_BYTES + 1), "<stdin>"), "<stdin>")
    name = shown(path)
    try:
        with open(path, "rb") as file:
            data = file.read(_MAX_BYTES + 1)
    except FileNotFoundError:
        raise InputError(f"{name}: {NO_SUCH_FILE}") from None
    except IsADirectoryError:
        raise InputError(
            f"{name}: is a directory, not a calibration or zoom table: name a file in it"
        ) from None
    except (OSError, ValueError) as error:
        raise InputError(f"{name}: cannot be read: {getattr(error, 'strerror', error)}") from None
    return loads(_decode(data, name), name)


def loads(document: str, name: str = "<string>") -> Calibration | ZoomTable:
    """Read a calibration or a zoom table from its TOML text; ``name`` is what errors call it."""
    try:
        data = tomllib.loads(document)
    except (tomllib.TOMLDecodeError, ValueError, RecursionError) as error:
        reason = "nested too deeply" if isinstance(error, RecursionError) else error
        raise InputError(f"{name}: not a TOML document: {reason}") from None
    section = Section(data)
    try:
        kind = _kind(section)
        return kind.read(section)
    except InputError as error:
        raise InputError(f"{name}: {error}") from None


def dumps(obj: Calibration | ZoomTable) -> str:
    """Return the TOML text: the same object gives the same text, and what is written reads back.

    Raises InputError for an object that ``load`` would refuse.
    """
    kind: ModuleType = zoomtable if isinstance(obj, ZoomTable) else calibration
    text = "\n".join(kind.write(obj)) + "\n"
    loads(text, "this result")
    return text


def save(obj: Calibration | ZoomTable, path: PathLike, overwrite: bool = False) -> None:
    """Write a calibration or a zoom table; ``-`` writes to standard output.

    Raises InputError for an object that ``load`` would refuse and OutputError for a file that exists
    (unless ``overwrite``) or cannot be written.
    """
    data = dumps(obj).encode()
    if os.fspath(path) == "-":
        sys.stdout.buffer.write(data)
        sys.stdout.buffer.flush()
        return
    with atomic_output(path, overwrite) as temporary:
        Path(temporary).write_bytes(data)


def _decode(data: bytes, name: str) -> str:
    if len(data) > _MAX_BYTES:
        raise InputError(f"{name}: too large to be a calibration or zoom table")
    if not data.strip():
        raise InputError(f"{name}: is empty: take another copy of it, or calibrate anew")
    try:
        # Some editors put a byte order mark in front, which TOML does not know.
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(f"{name}: not a calibration or zoom table: it is no text") from None


def _kind(document: Section) -> ModuleType:
    """Return the module that reads this document's schema."""
    if not document.has("schema"):
        raise InputError('not an endocal file: it has no key schema = "endocal.calibration/1"')
    schema = document.text("schema")
    match = re.fullmatch(r"([a-z.]+)/([1-9][0-9]{0,8})", schema)
    if match is None or match[1] not in _KINDS:
        known = " or ".join(f'"{name}/{kind.VERSION}"' for name, kind in _KINDS.items())
        raise InputError(f"schema is {schema[:60]!r}; it must be {known}")
    kind = _KINDS[match[1]]
    if int(match[2]) > kind.VERSION:
        raise InputError(
            f'schema "{schema}" is newer than what endocal {__version__} reads ("{match[1]}/{kind.VERSION}"):'
            " update endocal"
        )
    return kind
