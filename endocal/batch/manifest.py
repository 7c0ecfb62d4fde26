"""Manifests: which calibration goes with which recording, by name, pattern or the scope's serial number."""

from __future__ import annotations

import csv
import glob
import io
import os
import re
import tomllib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from ..errors import InputError
from ..files.names import shown
from ..files.section import Section
from .patterns import SERIAL, fixed_part, matches, serial_in
from .recording import STATE

MANIFEST_SUFFIXES = (".toml", ".csv")
SCHEMA = "endocal.manifest/1"

_COLUMNS = ("files", "calibration", "right_calibration", "serial", "output")


@dataclass(frozen=True)
class Lens:
    """The calibration of a scope, and that of its second eye, as absolute paths."""

    calibration: str | None
    right_calibration: str | None = None


@dataclass(frozen=True)
class Entry:
    """A recording of a manifest; ``where`` is what errors call its row."""

    source: str
    calibration: str | None
    right_calibration: str | None
    output: str | None
    where: str
    serial: str | None = None


@dataclass
class Manifest:
    """The recordings of a manifest, each once, and what it names that is not there."""

    entries: list[Entry] = field(default_factory=list)
    missing: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class _Row:
    """One rule as written: the files that it is for, and their lens."""

    where: str
    files: tuple[str, ...]
    lens: Lens
    serial: str | None
    output: str | None


def read_manifest(
    path: str, is_output: Callable[[str, str], bool] = lambda file, top: False
) -> Manifest:
    """Read a manifest (.toml or .csv); its paths count from its own directory.

    The first row that fits a recording tells its calibration. Of what a pattern matches below its fixed part
    ``top``, the files of which ``is_output`` says so are left out. Raises InputError, naming file and row,
    for a wrong manifest, a serial number without a calibration, and a calibration that is not there.
    """
    name = shown(path)
    try:
        text = Path(path).read_bytes().decode("utf-8-sig")
    except OSError as error:
        raise InputError(f"{name}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise InputError(f"{name}: is no text in UTF-8") from None
    try:
        is_toml = Path(path).suffix.lower() == ".toml"
        scopes, rows = _read_toml(text) if is_toml else ({}, _read_csv(text))
        return _expand(os.path.dirname(os.path.abspath(path)), scopes, rows, is_output)
    except InputError as error:
        raise InputError(f"{name}: {error}") from None


def _read_toml(text: str) -> tuple[dict[str, Lens], list[_Row]]:
    try:
        document = Section(tomllib.loads(text))
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise InputError(f"not a TOML document: {error}") from None
    if document.get("schema", None) != SCHEMA:
        raise InputError(
            f'a manifest begins with schema = "{SCHEMA}"; a calibration is given with --config'
        )
    scopes: dict[str, Lens] = {}
    for scope in document.sections("scope", "[[scope]]"):
        serial = scope.text("serial")
        if serial in scopes:
            raise InputError(f"two [[scope]] have the serial {serial!r}")
        scopes[serial] = Lens(scope.text("calibration"), scope.text("right_calibration", None))
        scope.close()
    rows = []
    for number, section in enumerate(document.sections("recording", "[[recording]]"), 1):
        files = section.get("files")
        row = _Row(
            f"[[recording]] {number}",
            (files,) if isinstance(files, str) else section.texts("files"),
            Lens(section.text("calibration", None), section.text("right_calibration", None)),
            section.text("serial", None),
            section.text("output", None),
        )
        section.close()
        rows.append(row)
    document.close()
    return scopes, rows


def _read_csv(text: str) -> list[_Row]:
    head = text.partition("\n")[0]
    separator = ";" if ";" in head and "," not in head else ","
    reader = csv.DictReader(io.StringIO(text), delimiter=separator, strict=True)
    rows = []
    try:
        names = [n.strip() for n in reader.fieldnames or ()]
        reader.fieldnames = names
        unknown = [n for n in names if n not in _COLUMNS]
        if "files" not in names or unknown:
            wrong = (
                f"the column {unknown[0]!r} is unknown" if unknown else "no column is called files"
            )
            raise InputError(f"{wrong}; there are {', '.join(_COLUMNS)}")
        for row in reader:
            where = f"line {reader.line_num}"
            if None in row:
                raise InputError(f"{where}: has more fields than the first line")
            values = {k: (v or "").strip() or None for k, v in row.items()}
            if not any(values.values()):
                continue
            if values["files"] is None:
                raise InputError(f"{where}: names no files")
            lens = Lens(values.get("calibration"), values.get("right_calibration"))
            serial, output = values.get("serial"), values.get("output")
            rows.append(_Row(where, (values["files"],), lens, serial, output))
    except csv.Error as error:
        raise InputError(f"line {reader.line_num}: {error}") from None
    return rows


def _expand(
    folder: str,
    scopes: Mapping[str, Lens],
    rows: list[_Row],
    is_output: Callable[[str, str], bool],
) -> Manifest:
    """Find the files of each row and the lens of each file."""
    if not rows:
        raise InputError("names no recordings")
    manifest, seen = Manifest(), set()
    for name, scope in scopes.items():
        _found(folder, scope, name, f"[[scope]] {name}")
    for row in rows:
        _check_output(row)
        if SERIAL not in f"{row.lens.calibration} {row.lens.right_calibration}":
            # Whether it has files of its own or not: a wrong name is a mistake.
            _found(folder, row.lens, None, row.where)
        for pattern in row.files:
            if os.path.isdir(os.path.join(folder, pattern)):
                raise InputError(f"{row.where}: {shown(pattern)} is a directory: add /* or /**/*")
            files = list(_files(folder, pattern))
            if not files:
                manifest.missing.append(f"{shown(pattern)} ({row.where}): no such file")
            for name, top in files:
                path = os.path.normpath(os.path.join(folder, name))
                if path in seen or (top is not None and is_output(path, top)):
                    continue
                seen.add(path)
                serial = row.serial
                if serial is None and top is not None and _wants_serial(row, pattern):
                    known = {*scopes, *_named_serials(folder, row.lens)}
                    serial = serial_in(name, os.path.normpath(pattern), known, folder)
                lens = _lens(folder, scopes, row, serial, path)
                output = None if row.output is None else os.path.normpath(row.output)
                manifest.entries.append(
                    Entry(path, lens.calibration, lens.right_calibration, output, row.where, serial)
                )
    return manifest


def _check_output(row: _Row) -> None:
    if row.output is None:
        return
    if len(row.files) > 1 or glob.has_magic(row.files[0]) or SERIAL in row.files[0]:
        raise InputError(f"{row.where}: output goes with one file, not with a pattern")
    place = os.path.normpath(row.output)
    if os.path.isabs(place) or place.split(os.sep)[0] == os.pardir:
        raise InputError(f"{row.where}: the output {row.output!r} is not below --out")
    if row.output.endswith("/") or place == os.curdir:
        raise InputError(f"{row.where}: the output {row.output!r} is a directory, not a file")
    if place.split(os.sep)[0] == STATE:
        raise InputError(f"{row.where}: the output {row.output!r} is in the ledger's directory")


def _files(folder: str, pattern: str) -> Iterator[tuple[str, str | None]]:
    """Yield the files of a pattern as paths from ``folder`` on, each with the pattern's fixed part.

    A file that goes by the very name comes without.
    """
    if os.path.lexists(os.path.join(folder, pattern)):
        yield pattern, None
        return
    pattern = os.path.normpath(pattern)
    top = os.path.join(folder, fixed_part(pattern, folder))
    for name in matches(pattern, folder):
        yield name, top


def _wants_serial(row: _Row, pattern: str) -> bool:
    """Tell whether the lens of a row follows from the serial number in a name."""
    named = f"{row.lens.calibration} {row.lens.right_calibration}"
    return SERIAL in pattern and (row.lens.calibration is None or SERIAL in named)


def _named_serials(folder: str, lens: Lens) -> Iterator[str]:
    """Yield the serial numbers of the calibrations that are there by a name with {serial} in it."""
    for name in (lens.calibration, lens.right_calibration):
        if name is None or SERIAL not in name:
            continue
        name = os.path.normpath(name)
        before, *rest = (re.escape(part) for part in name.split(SERIAL))
        again = "(?P=serial)".join(rest)
        for path in matches(glob.escape(name), folder):
            if found := re.fullmatch(f"{before}(?P<serial>[^/]+){again}", path):
                yield found["serial"]


def _lens(
    folder: str, scopes: Mapping[str, Lens], row: _Row, serial: str | None, path: str
) -> Lens:
    """Return the lens of a recording: of its row, else of its scope; empty where neither names one."""
    lens = row.lens
    if lens.calibration is None and serial is not None:
        if serial not in scopes:
            raise InputError(
                f"{row.where}: {shown(path)} has the serial number {serial!r}, and no [[scope]] has that"
            )
        lens = scopes[serial]
    return _found(folder, lens, serial, row.where)


def _found(folder: str, lens: Lens, serial: str | None, where: str) -> Lens:
    """Return a lens with absolute paths that are there; ``where`` is the row that names it."""

    def found(name: str | None) -> str | None:
        if name is None:
            return None
        if SERIAL in name and serial is None:
            raise InputError(f"{where}: {name!r} needs a serial number, in files or of its own")
        whole = os.path.normpath(os.path.join(folder, name.replace(SERIAL, serial or "")))
        if not os.path.isfile(whole):
            raise InputError(f"{where}: the calibration {shown(whole)} is missing")
        return whole

    return Lens(found(lens.calibration), found(lens.right_calibration))
