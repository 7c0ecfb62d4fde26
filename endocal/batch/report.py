"""What a batch came to: each recording with its numbers, for programs."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from .._version import __version__
from .ledger import DONE, FAILED, Entry
from .plan import LEAVE, WAIT, Plan, Step

SCHEMA = "endocal.batch-report/1"
# What became of a recording. ``left``: its output is not of this batch and was left alone.
LEFT, OPEN = "left", "open"


@dataclass(frozen=True)
class Line:
    """One recording of a batch: what became of it, and the facts of its correction.

    ``status`` is done, failed, left or open (not done yet); ``reason`` says why it failed or was left;
    ``now`` whether this run did it. ``calibrations`` are the paths of its calibration, and of the second
    eye's if any, each with its SHA-256, and ``serial`` is the scope's number that they were found by.
    ``facts`` are those of CorrectionReport, without the paths; empty where there is no output of ours.
    """

    place: str
    source: str
    status: str
    reason: str | None
    now: bool
    facts: Mapping[str, Any] = field(default_factory=dict)
    calibrations: tuple[tuple[str, str], ...] = ()
    serial: str | None = None

    @property
    def speed(self) -> float | None:
        """Frames per second of work."""
        seconds = self.facts.get("seconds")
        return self.facts["frames"] / seconds if seconds else None

    def shares(self) -> dict[str, float]:
        """Return the share of the frames by where their zoom came from."""
        counts = self.facts.get("zoom") or {}
        total = sum(counts.values())
        return {source: count / total for source, count in sorted(counts.items())}


@dataclass(frozen=True)
class BatchReport:
    """All recordings of a batch, sorted by place, whether this run did them or an earlier one.

    ``missing`` are recordings that a manifest names and that are not there. ``stopped`` says why the run
    ended before its time, if it did; ``interrupted`` that the user ended it, and ``exit_code`` how the
    command is to end then if it was by a signal other than Ctrl-C.
    """

    out: str
    lines: tuple[Line, ...]
    missing: tuple[str, ...]
    notes: tuple[str, ...]
    workers: str
    began: str
    seconds: float
    stopped: str | None = None
    interrupted: bool = False
    exit_code: int | None = None

    def count(self, status: str) -> int:
        """Return how many recordings have a status."""
        return Counter(line.status for line in self.lines)[status]

    @property
    def failures(self) -> int:
        """How many recordings failed, or are missing."""
        return self.count(FAILED) + len(self.missing)

    @property
    def done_now(self) -> int:
        """How many recordings this run did."""
        return sum(line.now and line.status == DONE for line in self.lines)

    @property
    def is_well(self) -> bool:
        """Whether all recordings are done: none failed, is missing, was left alone or is still open."""
        return not (self.failures or self.count(LEFT) or self.count(OPEN))

    def data(self) -> dict[str, Any]:
        """Return the report as plain data."""
        return {
            "schema": SCHEMA,
            "endocal": __version__,
            "began": self.began,
            "seconds": round(self.seconds, 3),
            "workers": self.workers,
            "interrupted": self.interrupted,
            "stopped": self.stopped,
            "counts": {
                "recordings": len(self.lines),
                **{status: self.count(status) for status in (DONE, FAILED, LEFT, OPEN)},
                "missing": len(self.missing),
                "done_now": self.done_now,
            },
            "missing": [_plain(m) for m in self.missing],
            "notes": [_plain(n) for n in self.notes],
            "recordings": [_data(line) for line in self.lines],
        }


def make_lines(
    plan: Plan, entries: Mapping[str, Entry], worked_on: frozenset[str]
) -> tuple[Line, ...]:
    """Return the lines of a plan after its run; ``worked_on`` are the places that the run took up."""
    return tuple(_line(step, entries.get(step.recording.place), worked_on) for step in plan.steps)


def _line(step: Step, entry: Entry | None, worked_on: frozenset[str]) -> Line:
    recording = step.recording
    status, reason = OPEN, None
    if step.action == LEAVE:
        status, reason = LEFT, step.reason
    elif step.action == WAIT:
        reason = step.reason
    elif entry is not None and entry.status in (DONE, FAILED):
        status, reason = entry.status, entry.error
        if status == FAILED and entry.made is not None and os.path.lexists(step.correction.output):
            reason = f"{reason} (what an earlier run made of it is still there)"
    facts = entry.made.report if status == DONE and entry is not None and entry.made else {}
    now = recording.place in worked_on
    place, source, serial = recording.place, recording.source, recording.serial
    return Line(place, source, status, reason, now, facts, step.calibrations, serial)


def _data(line: Line) -> dict[str, Any]:
    facts = dict(line.facts)
    seconds = facts.get("seconds")
    data: dict[str, Any] = {
        "output": _plain(line.place),
        "source": _plain(line.source),
        "status": line.status,
        "now": line.now,
        **{key: _plain(text) for key, text in lens_words(line.calibrations, line.serial).items()},
    }
    if line.reason is not None:
        data["reason"] = _plain(line.reason)
    if facts:
        data |= facts | {
            "seconds": round(seconds, 3) if seconds is not None else None,
            "fps": None if line.speed is None else round(line.speed, 2),
            "zoom_shares": {k: round(v, 4) for k, v in line.shares().items()},
        }
    return data


def lens_words(calibrations: Sequence[tuple[str, str]], serial: str | None) -> dict[str, str]:
    """Return which calibrations a recording gets, as the fields of its row."""
    words: dict[str, str] = {}
    for eye, (path, digest) in zip(("", "right_"), calibrations, strict=False):
        words |= {f"{eye}calibration": path, f"{eye}calibration_sha256": digest}
    return words if serial is None else words | {"serial": serial}


def _plain(text: str) -> str:
    """Return text that is Unicode: bytes of file names that are none are escaped."""
    return text.encode(errors="backslashreplace").decode()
