"""The recordings that the sources hold, and where the output of each goes."""

from __future__ import annotations

import fnmatch
import glob
import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import PurePath

from ..errors import InputError, UsageError
from ..files.names import shown
from .manifest import MANIFEST_SUFFIXES, read_manifest
from .patterns import fixed_part, matches
from .recording import HTML_REPORT, JSON_REPORT, STATE, BatchSpec, Recording


@dataclass
class Found:
    """What was found: recordings by their outputs' places, notes, and what a manifest names in vain."""

    recordings: dict[str, Recording] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    missing: list[str] = field(default_factory=list)
    # By the sources' paths, links to directories followed: one is found by two ways, under two places.
    by_source: dict[str, Recording] = field(default_factory=dict)


def find_recordings(spec: BatchSpec) -> Found:
    """Return the recordings of all sources, sorted by place.

    Raises InputError for a source that is not there or holds nothing, and UsageError where two recordings
    would get one output, or an output would be an input.
    """
    found = Found()
    for source in spec.sources:
        _add_source(found, spec, source)
    if not found.recordings and not found.missing:
        names = ", ".join(map(shown, spec.sources))
        raise InputError(f"{names}: no recording was found")
    found.recordings = dict(sorted(found.recordings.items()))
    _refuse_circles(spec, found.recordings.values())
    return found


def _add_source(found: Found, spec: BatchSpec, source: str) -> None:
    if os.path.isdir(source):
        for path in _walk(found, spec, source):
            _add(found, spec, path, source)
    elif os.path.lexists(source):
        if PurePath(source).suffix.lower() in MANIFEST_SUFFIXES:
            _add_manifest(found, spec, source)
        else:
            _add(found, spec, source, os.path.dirname(source))
    elif glob.has_magic(source):
        paths, top = matches(source), fixed_part(source)
        if not paths:
            raise InputError(f"{shown(source)}: matches no file")
        for path in paths:
            if not _is_output(found, spec, path, top):
                _add(found, spec, path, top)
    else:
        raise InputError(f"{shown(source)}: no such file or directory: check its name")


def _add_manifest(found: Found, spec: BatchSpec, path: str) -> None:
    folder = os.path.dirname(os.path.abspath(path))
    manifest = read_manifest(path, lambda file, top: _is_output(found, spec, file, top))
    found.missing += manifest.missing
    for entry in manifest.entries:
        calibration, right = entry.calibration, entry.right_calibration
        if calibration is None:
            calibration, right = _default_lens(spec)
        if calibration is None:
            raise InputError(
                f"{shown(path)}: {entry.where} gives no calibration, nor does --config: add a calibration"
                " or a serial"
            )
        inside = os.path.commonpath([folder, entry.source]) == folder
        root = folder if inside else os.path.dirname(entry.source)
        place = entry.output or _place(spec, entry.source, root)
        recording = Recording(entry.source, place, calibration, right, entry.serial)
        _put(found, recording, is_place_given=entry.output is not None)


def _add(found: Found, spec: BatchSpec, path: str, root: str) -> None:
    calibration, right = _default_lens(spec)
    if calibration is None:
        raise UsageError("-c FILE, the calibration or zoom table, is needed without a manifest")
    source = os.path.abspath(path)
    _put(found, Recording(source, _place(spec, source, root), calibration, right))


def _default_lens(spec: BatchSpec) -> tuple[str | None, str | None]:
    paths = (spec.calibration, spec.right_calibration)
    left, right = (None if path is None else os.path.abspath(path) for path in paths)
    return left, right


def _put(found: Found, recording: Recording, is_place_given: bool = False) -> None:
    """Take a recording, once for all sources that hold it, save where one gives it a place of its own."""
    folder, name = os.path.split(recording.source)
    first = found.by_source.setdefault(os.path.join(os.path.realpath(folder), name), recording)
    if first is not recording:
        lenses = {(r.calibration, r.right_calibration) for r in (first, recording)}
        if len(lenses) > 1:
            raise UsageError(
                f"{shown(recording.source)} is named by two sources, with the calibrations"
                f" {shown(first.calibration)} and {shown(recording.calibration)}: leave one out"
            )
        if not is_place_given:
            return
    other = found.recordings.setdefault(recording.place, recording)
    if other.source == recording.source:
        return
    if os.path.realpath(other.source) != os.path.realpath(recording.source):
        raise UsageError(
            f"{shown(other.source)} and {shown(recording.source)} would both become"
            f" {shown(recording.place)}: keep them apart with --root DIR, or name one directory as the source"
        )


def _place(spec: BatchSpec, source: str, root: str) -> str:
    """Return where the output goes, below the directory of outputs."""
    start = os.path.abspath(spec.root if spec.root is not None else root or ".")
    place = os.path.relpath(source, start)
    if place.split(os.sep)[0] == os.pardir:
        raise UsageError(f"{shown(source)} is not below --root {shown(spec.root or start)}")
    if spec.suffix is not None and not _is_picture(place):
        place = os.path.splitext(place)[0] + spec.suffix
    return place


def _is_picture(place: str) -> bool:
    from ..files.images import PICTURE_SUFFIXES

    return os.path.splitext(place)[1].lower() in PICTURE_SUFFIXES


def _walk(found: Found, spec: BatchSpec, top: str) -> Iterator[str]:
    """Yield the files of a directory, and with ``recursive`` of those below it, hidden ones left out."""

    def unreadable(error: OSError) -> None:
        found.missing.append(f"{shown(error.filename)}: {error.strerror}")

    out = os.path.realpath(spec.out)
    if os.path.realpath(top) == out:
        raise UsageError(
            f"{shown(top)} is both a source and --out: give the outputs a place of their own"
        )
    for folder, folders, files in os.walk(top, onerror=unreadable):
        for name in sorted(folders):
            path = os.path.join(folder, name)
            if name.startswith(".") or os.path.realpath(path) == out:
                folders.remove(name)
            elif reason := _reason_to_stay_out(spec, path):
                folders.remove(name)
                found.notes.append(f"{shown(path)}: {reason}")
        folders.sort()
        for name in sorted(files):
            path = os.path.join(folder, name)
            if not name.startswith(".") and _is_wanted(spec, os.path.relpath(path, top)):
                yield path


def _reason_to_stay_out(spec: BatchSpec, folder: str) -> str | None:
    if not spec.recursive:
        return "is a directory, left out without --recursive"
    if os.path.islink(folder):
        return "is a link to a directory, and is not followed: name it as a source"
    return _ANOTHER if _holds_outputs(folder) else None


_ANOTHER = "holds the outputs of another batch, and is left out: name it as a source"


def _holds_outputs(folder: str) -> bool:
    """Tell a directory of outputs by what a batch leaves there; with --state elsewhere, the report."""
    return any(os.path.lexists(os.path.join(folder, name)) for name in (STATE, JSON_REPORT))


def _is_output(found: Found, spec: BatchSpec, path: str, top: str) -> bool:
    """Tell whether a file that a pattern matches is in a directory of outputs below ``top``, its fixed part.

    Such a directory is left out as it is where a directory is the source; another batch's with a note.
    """
    out, top = os.path.realpath(spec.out), os.path.abspath(top)
    folder = os.path.dirname(os.path.abspath(path))
    while len(folder) > len(top):
        if os.path.realpath(folder) == out:
            return True
        if _holds_outputs(folder):
            note = f"{shown(folder)}: {_ANOTHER}"
            if note not in found.notes:
                found.notes.append(note)
            return True
        folder = os.path.dirname(folder)
    return False


def _is_wanted(spec: BatchSpec, path: str) -> bool:
    """Tell whether the patterns let a file in; they match its name or its path below the source.

    A record of a zoom, which goes with a recording, is none itself.
    """
    if spec.zoom_from is not None and path.endswith(spec.zoom_from):
        return False

    def fits(patterns: Sequence[str]) -> bool:
        names = (path, os.path.basename(path))
        return any(fnmatch.fnmatchcase(n, p) for p in patterns for n in names)

    return (not spec.include or fits(spec.include)) and not fits(spec.exclude)


def _refuse_circles(spec: BatchSpec, recordings: Iterable[Recording]) -> None:
    recordings = list(recordings)
    inputs = {os.path.realpath(r.source) for r in recordings}
    out = os.path.realpath(spec.out)
    for recording in recordings:
        output = os.path.join(out, recording.place)
        if recording.place in (JSON_REPORT, HTML_REPORT):
            raise UsageError(f"{shown(recording.source)} would get the name of the batch's report")
        if recording.place.split(os.sep)[0] == STATE:
            raise UsageError(f"{shown(recording.source)} would get into the ledger's directory")
        if output in inputs or os.path.realpath(output) in inputs:
            raise UsageError(
                f"{shown(output)} would be an output and is an input: give --out another directory"
            )
