"""What is to be done: each recording beside what the ledger and the disk say of it."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from functools import cache, cached_property
from typing import Any

from .._version import __version__
from ..errors import InputError, UsageError
from ..files import load
from ..files.names import shown
from ..jobs.correct import holds_picture
from ..jobs.correction import CorrectionSpec
from ..video.encoder import EncoderChoice
from ..zoom.table import ZoomTable
from .fingerprint import FileState, sha256
from .ledger import FAILED, RUNNING, Entry
from .recording import BatchSpec, Recording
from .sources import find_recordings
from .task import lens_digest

# What a step does: correct; compare the input's SHA-256 with the ledger's, and correct if it differs;
# nothing, since it is done; nothing, since the output is not ours; nothing now, since --retry-failed is for
# other work.
DO, CHECK, KEEP, LEAVE, WAIT = "do", "check", "keep", "leave", "wait"
# Of CorrectionSpec, these are not what makes an output what it is, or have a digest of their own.
_NOT_OPTIONS = ("input", "output", "calibration", "right_calibration", "overwrite", "threads")
_ZOOM_OPTIONS = ("lookup", "assume_diameter", "zoom_log", "zoom_from")


@dataclass(frozen=True)
class Step:
    """One recording and what is to be done with it, and why.

    ``calibrations`` are the paths of its calibration, and of the second eye's if any, each with the SHA-256
    of its bytes. ``correction`` is the whole order, and ``page`` the path of its report; ``owned`` says that
    the output may be replaced. ``lens_sha256`` is of the calibration's bytes, and of those of a second one
    and of the zoom's record where there are any.
    """

    recording: Recording
    action: str
    reason: str
    correction: CorrectionSpec
    page: str | None
    owned: bool
    lens_sha256: str
    options_sha256: str
    entry: Entry | None
    calibrations: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Plan:
    """The steps by place, what is to be said of the sources, and what a manifest names in vain."""

    steps: tuple[Step, ...]
    notes: tuple[str, ...]
    missing: tuple[str, ...]

    @cached_property
    def todo(self) -> list[Step]:
        """The steps with work, the largest recording first, so that none is left for the end alone.

        What failed before comes last, so that --fail-fast gets to the others.
        """

        def order(step: Step) -> tuple[bool, int]:
            failed = step.entry is not None and step.entry.status == FAILED
            return failed, -_size(step.recording.source)

        return sorted((s for s in self.steps if s.action in (DO, CHECK)), key=order)


def make_plan(spec: BatchSpec, entries: Mapping[str, Entry]) -> Plan:
    """Find the recordings and decide on each.

    Raises InputError for a source or a calibration that is not there or not sound, and UsageError for
    options that contradict each other: nothing has been touched then.
    """
    _is_table.cache_clear()
    _digest.cache_clear()
    found = find_recordings(spec)
    steps = tuple(
        _step(spec, recording, entries.get(recording.place))
        for recording in found.recordings.values()
    )
    _refuse_idle_zoom_options(spec, steps)
    _refuse_shared_files(steps)
    notes = list(found.notes)
    if others := entries.keys() - found.recordings.keys():
        are = "recording is" if len(others) == 1 else "recordings are"
        notes.append(
            f"{len(others)} more {are} in the ledger of --out, and not among these sources"
        )
    versions = {
        step.entry.made.endocal
        for step in steps
        if step.action == KEEP and step.entry is not None and step.entry.made is not None
    } - {__version__}
    if versions:
        notes.append(
            f"some outputs were made by endocal {', '.join(sorted(versions))}: --redo makes them anew"
        )
    return Plan(steps, tuple(notes), tuple(found.missing))


def _step(spec: BatchSpec, recording: Recording, entry: Entry | None) -> Step:
    correction = _correction(spec, recording)
    lens = lens_digest(correction, _digest)
    paths = (recording.calibration, recording.right_calibration)
    calibrations = tuple((path, _digest(path)) for path in paths if path is not None)
    page = None if spec.report is None else os.path.splitext(correction.output)[0] + spec.report
    options = _options_digest(correction, spec.report)
    exists = os.path.lexists(correction.output)
    owned = exists and _is_ours(correction.output, entry)
    if exists and not owned and not spec.overwrite:
        known = entry is not None and entry.made is not None
        reason = "was changed by someone else" if known else "exists, and is not of this batch"
        return Step(
            recording, LEAVE, reason, correction, page, False, lens, options, entry, calibrations
        )
    gone = _missing_beside(correction, page)
    action, reason = _decide(spec, recording, entry, exists, gone, lens, options)
    if spec.retry_failed and action in (DO, CHECK) and not (entry and entry.status == FAILED):
        action, reason = WAIT, f"{reason}, and did not fail before"
    # What is beside a missing output is of this batch where that was made with the same options.
    made = entry is not None and entry.made is not None and entry.made.options_sha256 == options
    return Step(
        *(recording, action, reason, correction, page, exists or made),
        *(lens, options, entry, calibrations),
    )


def _missing_beside(correction: CorrectionSpec, page: str | None) -> str | None:
    """Name what should be beside an output and is not; beside pictures there is nothing."""
    for name, path in (("zoom log", correction.zoom_log), ("page", page)):
        if path is not None and not os.path.lexists(path) and not holds_picture(correction.input):
            return name
    return None


def _decide(
    spec: BatchSpec,
    recording: Recording,
    entry: Entry | None,
    exists: bool,
    gone: str | None,
    lens: str,
    options: str,
) -> tuple[str, str]:
    if entry is None:
        return DO, "replaces what is there" if exists else "new"
    if entry.status == FAILED:
        return DO, "failed before"
    if entry.status == RUNNING or entry.made is None:
        return DO, "was interrupted"
    made = entry.made
    for differs, reason in (
        (not exists, "its output is missing"),
        (spec.redo, "--redo"),
        (made.lens_sha256 != lens, "its calibration has changed"),
        (made.options_sha256 != options, "its options have changed"),
        (gone is not None, f"its {gone} is missing"),
    ):
        if differs:
            return DO, reason
    try:
        unchanged = FileState.of(recording.source) == made.input_state
    except OSError:
        return DO, "it cannot be read"
    if spec.rehash:
        return CHECK, "its input and output are compared"
    # What failed is all that --retry-failed reads.
    if unchanged and (made.input_settled or spec.retry_failed):
        return KEEP, "done"
    return CHECK, "its input was touched" if not unchanged else "its input is compared"


def _is_ours(output: str, entry: Entry | None) -> bool:
    """Tell whether an output that is there came from this batch."""
    if entry is None:
        return False
    if entry.status == RUNNING:
        # It appeared between the order and the record of it.
        return True
    try:
        return entry.made is not None and os.stat(output).st_size == entry.made.output_size
    except OSError:
        return False


def _correction(spec: BatchSpec, recording: Recording) -> CorrectionSpec:
    output = os.path.join(os.path.abspath(spec.out), recording.place)
    values: dict[str, Any] = dict(spec.correction)
    if _is_table(recording.calibration):
        if spec.zoom_log is not None:
            values["zoom_log"] = os.path.splitext(output)[0] + spec.zoom_log
        if spec.zoom_from is not None:
            values["zoom_from"] = os.path.splitext(recording.source)[0] + spec.zoom_from
    else:
        values = {k: v for k, v in values.items() if k not in _ZOOM_OPTIONS}
    return CorrectionSpec(
        input=recording.source,
        output=output,
        calibration=recording.calibration,
        right_calibration=recording.right_calibration,
        **values,
    )


def _refuse_idle_zoom_options(spec: BatchSpec, steps: tuple[Step, ...]) -> None:
    """Refuse options for a zoom table where no recording has one."""
    if any(_is_table(step.recording.calibration) for step in steps):
        return
    for option, given in (
        ("--zoom-log", spec.zoom_log is not None),
        ("--zoom-from", spec.zoom_from is not None),
        ("--assume-diameter", spec.correction.get("assume_diameter") is not None),
        ("--lookup", spec.correction.get("lookup", "auto") != "auto"),
    ):
        if given:
            raise UsageError(f"{option} needs a zoom table, and no recording has one")


def _refuse_shared_files(steps: tuple[Step, ...]) -> None:
    """Refuse two outputs, or what is beside them, of one name: a.mp4 and a.mov would both write a.csv."""
    writers: dict[str, str] = {}
    for step in steps:
        spec = step.correction
        for path in filter(None, (spec.output, spec.zoom_log, step.page)):
            place, path = step.recording.place, os.path.normpath(path)
            if path in writers:
                names = f"{shown(writers[path])} and {shown(place)}"
                raise UsageError(f"{names} would both write {shown(path)}: take another suffix")
            writers[path] = place


def _options_digest(correction: CorrectionSpec, page: str | None) -> str:
    """Return the SHA-256 of what differs from the defaults, so that a new option changes no old digest."""
    plain = CorrectionSpec("", "", "")
    differing: dict[str, Any] = {} if page is None else {"report": page}
    for field in fields(CorrectionSpec):
        value = getattr(correction, field.name)
        if field.name in _NOT_OPTIONS or value == getattr(plain, field.name):
            continue
        if field.name in ("zoom_log", "zoom_from"):
            # Their content counts, or their kind, and not where they are.
            value = os.path.splitext(value)[1]
        if isinstance(value, EncoderChoice):
            value = {k: v for k, v in asdict(value).items() if v != getattr(plain.encoder, k)}
        differing[field.name] = value
    return hashlib.sha256(json.dumps(differing, sort_keys=True).encode()).hexdigest()


def _size(path: str) -> int:
    try:
        return os.stat(path).st_size
    except OSError:
        return 0


@cache
def _is_table(path: str) -> bool:
    return isinstance(load(path), ZoomTable)


@cache
def _digest(path: str) -> str:
    load(path)
    try:
        return sha256(path)
    except OSError as error:
        raise InputError(f"{shown(path)}: cannot be read: {error.strerror}") from None
