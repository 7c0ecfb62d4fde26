"""What a batch is told, and the recordings that follow from it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ..errors import UsageError

JSON_REPORT, HTML_REPORT = "batch-report.json", "batch-report.html"
STATE = ".endocal"


@dataclass(frozen=True)
class BatchSpec:
    """All that a batch can be told.

    ``sources`` are files, patterns, directories and manifests, ``out`` the directory that gets the outputs
    in the same tree; that tree begins at ``root`` where one is given. ``include`` and ``exclude`` are
    patterns for what is taken from directories. ``calibration`` (and ``right_calibration``, for the second
    eye) holds for recordings that no manifest gives another. ``correction`` holds fields of CorrectionSpec.
    ``suffix`` is that of the output videos, the source's if None; ``zoom_log`` and ``report`` are suffixes
    too, of files beside each output, and ``zoom_from`` of files beside each source. ``state`` is where the
    ledger is, by default in ``out``.

    ``jobs`` recordings are worked on at once, with ``threads`` threads each; None: by cores and memory.
    ``scheduler`` is the address of a Dask scheduler, whose workers are used instead. What fails for a reason
    outside the recording (a lost worker, a network drive) is tried ``retries`` times more; a recording that
    has not moved on by a frame for ``patience_s`` seconds is given up.

    ``overwrite`` replaces outputs that the ledger does not know; ``redo`` does again what is done;
    ``rehash`` trusts no timestamp and no size; ``retry_failed`` does only what failed before; ``fail_fast``
    begins nothing after the first failure.
    """

    sources: tuple[str, ...]
    out: str
    calibration: str | None = None
    right_calibration: str | None = None
    correction: Mapping[str, Any] = field(default_factory=dict)
    recursive: bool = False
    root: str | None = None
    include: tuple[str, ...] = ()
    exclude: tuple[str, ...] = ()
    suffix: str | None = None
    zoom_log: str | None = None
    zoom_from: str | None = None
    report: str | None = None
    state: str | None = None
    jobs: int | None = None
    threads: int | None = None
    scheduler: str | None = None
    retries: int = 2
    patience_s: float = 3600.0
    overwrite: bool = False
    redo: bool = False
    rehash: bool = False
    retry_failed: bool = False
    fail_fast: bool = False

    def __post_init__(self) -> None:
        for option, value, least in (
            ("--jobs", self.jobs, 1),
            ("--threads", self.threads, 1),
            ("--retries", self.retries, 0),
        ):
            if value is not None and value < least:
                raise UsageError(f"{option} {value}: it is {least} or more")
        if not self.out:
            raise UsageError("--out is empty: name a directory")
        if not self.patience_s > 0:
            raise UsageError(f"--patience {self.patience_s / 60:g}: it is more than 0 minutes")
        if self.jobs is not None and self.scheduler is not None:
            raise UsageError(
                "--jobs is for this machine: the cluster's workers say how many at once"
            )
        if self.redo and self.retry_failed:
            raise UsageError("--redo and --retry-failed exclude each other")
        if "-" in (self.calibration, self.right_calibration):
            raise UsageError("a batch's calibration is a file: it is read again for each recording")
        for option, suffix in (
            ("--suffix", self.suffix),
            ("--zoom-log", self.zoom_log),
            ("--zoom-from", self.zoom_from),
            ("--report", self.report),
        ):
            if suffix is not None and not (suffix.startswith(".") and "/" not in suffix):
                raise UsageError(
                    f"{option} {suffix}: in a batch it is a suffix, such as .mkv or .csv"
                )


@dataclass(frozen=True)
class Recording:
    """One recording, and where its output goes: ``place``, a path below the directory of outputs.

    ``source``, ``calibration`` and ``right_calibration`` are absolute paths. ``serial`` is the scope's number
    that the calibration was found by, where a manifest has one.
    """

    source: str
    place: str
    calibration: str
    right_calibration: str | None = None
    serial: str | None = None
