"""What a worker does with one recording: prove the input, correct it, prove the output."""

from __future__ import annotations

import errno
import os
import stat
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import Any

from .._version import __version__
from ..errors import EndocalError, OutputError
from ..files.atomic import marked_temporaries
from ..files.names import shown
from ..jobs.correct import correct, holds_picture
from ..jobs.correction import CorrectionReport, CorrectionSpec, Progress
from ..video.encoder import EncoderChoice
from .fingerprint import FileState, combined, sha256
from .ledger import Made

# The reasons of the system, rather than of the recording, that may be gone the next time.
_PASSING = (
    *(errno.EIO, errno.ESTALE, errno.ETIMEDOUT, errno.EHOSTUNREACH, errno.ENETDOWN),
    *(errno.ENETUNREACH, errno.ECONNRESET, errno.EHOSTDOWN, errno.EMFILE, errno.ENFILE),
    errno.ENOMEM,
)
_FULL = (errno.ENOSPC, errno.EDQUOT)
_TELL_EVERY_S = 0.5

Tell = Callable[[Progress], None]


@dataclass(frozen=True)
class Task:
    """One order for a worker. All paths are absolute, and the same on every machine.

    ``known_sha256`` is that of the input that the present output was made from, where only a change of it
    asks for work, and ``output_sha256`` that of the output, where a change of that does, too. ``mark`` is in
    the names of temporary files. ``page`` is the path of the recording's own report, if there is to be one.
    ``version`` is endocal's.
    """

    place: str
    correction: CorrectionSpec
    lens_sha256: str
    options_sha256: str
    known_sha256: str | None
    mark: str
    page: str | None = None
    output_sha256: str | None = None
    version: str = __version__


@dataclass(frozen=True)
class Outcome:
    """How a task ended: with ``made``, or unchanged with the input's new ``state``, or with an ``error``.

    ``passing`` says that the reason may be gone the next time, ``full`` that the disk is full.
    """

    made: Made | None = None
    unchanged: tuple[FileState, bool] | None = None
    error: str | None = None
    passing: bool = False
    full: bool = False


def perform(task: Task, tell: Tell = lambda progress: None) -> Outcome:
    """Do one task. Whatever is wrong with the recording, or with the machine, is in the outcome.

    ``tell`` is told about twice a second how far it is; an exception that it raises ends the task and is
    raised.
    """
    try:
        with marked_temporaries(task.mark):
            return _perform(task, _sparingly(tell))
    except EndocalError as error:
        numbers = _numbers(error)
        passing = any(n in _PASSING for n in numbers)
        return Outcome(error=str(error), passing=passing, full=any(n in _FULL for n in numbers))
    except MemoryError:
        return Outcome(error=f"{shown(task.correction.input)}: out of memory", passing=True)
    except OSError as error:
        name = shown(error.filename or task.correction.input)
        passing = error.errno in _PASSING
        return Outcome(
            error=f"{name}: {error.strerror or error}", passing=passing, full=error.errno in _FULL
        )


def lens_digest(correction: CorrectionSpec, digest: Callable[[str], str] = sha256) -> str:
    """Return one SHA-256 for all that tells the lens: calibrations, and the record of the zoom if any.

    ``digest`` gives that of a calibration.
    """
    paths = (correction.calibration, correction.right_calibration)
    digests = [digest(path) for path in paths if path is not None]
    if correction.zoom_from is not None and os.path.isfile(correction.zoom_from):
        digests.append(sha256(correction.zoom_from))
    return combined(digests)


def stuck(source: str, seconds: float) -> str:
    """Say that a recording does not move on."""
    return f"{shown(source)}: has not moved on for {seconds / 60:.3g} minutes, and is given up (--patience)"


def _perform(task: Task, tell: Tell) -> Outcome:
    source = task.correction.input
    if not stat.S_ISREG(os.stat(source).st_mode):
        return Outcome(error=f"{shown(source)}: is no regular file")
    before = FileState.of(source)
    began = time.time()
    digest = sha256(source, lambda count: tell(Progress(0, None, 0.0)))
    settled = before.is_settled(began)
    if digest == task.known_sha256 and _is_output_whole(task, tell):
        return Outcome(unchanged=(before, settled))
    if lens_digest(task.correction) != task.lens_sha256:
        name = shown(task.correction.calibration)
        return Outcome(error=f"{shown(source)}: {name} has changed since the batch began")
    _make_directory(os.path.dirname(task.correction.output))
    report = _correct(task, tell)
    output = task.correction.output
    if FileState.of(source) != before:
        os.unlink(output)
        return Outcome(
            error=f"{shown(source)}: changed while it was read: is it being recorded still?"
        )
    made = Made(
        input_sha256=digest,
        input_state=before,
        input_settled=settled,
        lens_sha256=task.lens_sha256,
        options_sha256=task.options_sha256,
        endocal=__version__,
        output_sha256=sha256(output, lambda count: tell(_finished(report))),
        output_size=os.stat(output).st_size,
        report=_facts(report),
    )
    return Outcome(made=made)


def _is_output_whole(task: Task, tell: Tell) -> bool:
    """Tell whether the output has the bytes that were recorded, where they are to be compared."""
    if task.output_sha256 is None:
        return True
    found = sha256(task.correction.output, lambda count: tell(Progress(0, None, 0.0)))
    return found == task.output_sha256


def _correct(task: Task, tell: Tell) -> CorrectionReport:
    spec = task.correction
    if holds_picture(spec.input):
        # What is said of the encoder and of the zoom over time is meant for the videos of the tree.
        return correct(replace(spec, encoder=EncoderChoice(), zoom_log=None, zoom_from=None), tell)
    if task.page is None:
        return correct(spec, tell)
    from ..jobs.report_run import correct_and_report

    return correct_and_report(spec, task.page, tell)


def _make_directory(path: str) -> None:
    try:
        os.makedirs(path, exist_ok=True)
    except OSError as error:
        raise OutputError(f"{shown(path)}: cannot be made: {error.strerror}") from error


def _facts(report: CorrectionReport) -> dict[str, Any]:
    """Return what is kept of a report: all but the paths, which the ledger has."""
    facts = asdict(report)
    for key in ("input", "output", "latency"):
        del facts[key]
    return facts


def _finished(report: CorrectionReport) -> Progress:
    return Progress(report.frames, report.frames, report.seconds)


def _sparingly(tell: Tell) -> Tell:
    last = -_TELL_EVERY_S

    def seldom(progress: Progress) -> None:
        nonlocal last
        now = time.monotonic()
        if now - last >= _TELL_EVERY_S:
            last = now
            tell(progress)

    return seldom


def _numbers(error: BaseException | None) -> list[int | None]:
    """Return the system's error numbers behind an error."""
    numbers = []
    while error is not None:
        numbers.append(getattr(error, "errno", None))
        error = error.__cause__
    return numbers
