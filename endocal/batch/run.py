"""Run a batch: the job behind ``endocal batch``."""

from __future__ import annotations

import contextlib
import json
import os
import secrets
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Protocol

from ..errors import OutputError, UsageError
from ..files import atomic_output
from ..files.atomic import remove_temporaries
from ..files.names import shown
from .executor import Ended, Event, Executor
from .ledger import NAME, RUNNING, Ledger, open_ledger
from .lock import Lock, hold_lock
from .options import check_options
from .page import report_page
from .plan import CHECK, Plan, Step, make_plan
from .processes import Processes
from .recording import HTML_REPORT, JSON_REPORT, STATE, BatchSpec
from .report import BatchReport, make_lines
from .resources import cores, default_jobs
from .task import Outcome, Task

# Facts that the ledger keeps: that a report was written, and whose outputs it tells of if kept elsewhere.
_REPORTED, _OUT = "reported", "out"


class Watch(Protocol):
    """Whoever wants to see how a batch goes on."""

    def planned(self, plan: Plan, workers: str) -> None:
        """See what is to be done."""
        ...

    def happened(self, event: Event) -> None:
        """See what happened to a recording."""
        ...


def preview_batch(spec: BatchSpec) -> Plan:
    """Return what a batch would do, and touch nothing."""
    check_options(spec)
    path = _state(spec) / NAME
    if not path.exists():
        return make_plan(spec, {})
    with open_ledger(path, read_only=True) as ledger:
        return make_plan(spec, ledger.entries())


def run_batch(spec: BatchSpec, watch: Watch) -> BatchReport:
    """Do what is missing, changed or failed, and write the report of the whole.

    What fails is recorded and does not end the batch. An interrupt, or a signal that comes as SystemExit,
    ends it well: the report says so. Raises
    EndocalError where nothing can start or go on: a wrong source, a missing calibration, another batch at
    work, a ledger that cannot be written.
    """
    began, clock = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()), time.monotonic()
    state = _state(spec)
    check_options(spec)
    # Nothing is made before the first plan stands.
    first = None if state.exists() else make_plan(spec, {})
    # With the ledger elsewhere, this marks the directory of outputs and keeps batches of other ledgers out.
    mark = Path(spec.out, STATE)
    for folder in (mark, state):
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            name = spec.out if folder is mark else folder
            raise OutputError(f"{shown(name)}: cannot be made: {error.strerror}") from None
    run = secrets.token_hex(4)
    with (
        hold_lock(state / "lock", run, shown(spec.out)) as lock,
        contextlib.nullcontext()
        if mark.samefile(state)
        else hold_lock(mark / "lock", run, shown(spec.out), optional=True),
        open_ledger(state / NAME) as ledger,
    ):
        _check_place(spec, ledger)
        _check_reports(spec, ledger)
        entries = ledger.entries()
        _clean(spec, ledger, {e.place for e in entries.values() if e.status == RUNNING})
        plan = make_plan(spec, entries) if first is None or entries else first
        work = _Work(spec, plan, ledger, watch)
        with _executor(spec, run, lock, bool(plan.todo)) as executor:
            work.do(executor)
        _clean(spec, ledger, work.taken)
        report = BatchReport(
            out=spec.out,
            lines=make_lines(plan, ledger.entries(), frozenset(work.worked_on)),
            missing=plan.missing,
            notes=plan.notes,
            workers=work.workers,
            began=began,
            seconds=time.monotonic() - clock,
            stopped=work.stopped,
            interrupted=work.interrupted is not None,
            exit_code=_exit_code(work.interrupted),
        )
        ledger.note(_REPORTED, "yes")
        _write_reports(spec, report)
    return report


class _Work:
    """The run of a plan: what is handed out is in the ledger first, and what comes back at once."""

    def __init__(self, spec: BatchSpec, plan: Plan, ledger: Ledger, watch: Watch) -> None:
        self._spec, self._plan, self._ledger, self._watch = spec, plan, ledger, watch
        self._steps = {step.recording.place: step for step in plan.todo}
        # Places handed out, and those of them that came back done anew or failed.
        self.taken: set[str] = set()
        self.worked_on: set[str] = set()
        self.workers = ""
        self.stopped: str | None = None
        # Ctrl-C, or a signal (SIGTERM, SIGHUP) as SystemExit.
        self.interrupted: KeyboardInterrupt | SystemExit | None = None

    def do(self, executor: Executor) -> None:
        """Run the steps that have work."""
        self.workers = executor.describe()
        self._watch.planned(self._plan, self.workers)
        events = executor.run(self._tasks())
        try:
            with contextlib.closing(events):  # type: ignore[type-var]
                for event in events:
                    if isinstance(event, Ended):
                        self._record(event.place, event.outcome)
                    self._watch.happened(event)
        except (KeyboardInterrupt, SystemExit) as end:
            self.interrupted = end

    def _tasks(self) -> Iterator[Task]:
        """Yield the tasks, one when there is room for it, until the run is to stop."""
        for place, step in self._steps.items():
            if self.stopped is not None:
                return
            self._ledger.begin(step.recording)
            self.taken.add(place)
            yield self._task(step)

    def _task(self, step: Step) -> Task:
        threads = self._spec.threads or _default_threads(self._spec)
        entry = step.entry
        known = output = None
        if step.action == CHECK and entry is not None and entry.made is not None:
            known = entry.made.input_sha256
            output = entry.made.output_sha256 if self._spec.rehash else None
        return Task(
            place=step.recording.place,
            correction=replace(step.correction, overwrite=step.owned, threads=threads),
            lens_sha256=step.lens_sha256,
            options_sha256=step.options_sha256,
            known_sha256=known,
            mark=self._ledger.mark,
            page=step.page,
            output_sha256=output,
        )

    def _record(self, place: str, outcome: Outcome) -> None:
        entry = self._steps[place].entry
        if outcome.made is not None:
            self._ledger.finish(place, outcome.made)
        elif outcome.unchanged is not None and entry is not None and entry.made is not None:
            state, settled = outcome.unchanged
            made = replace(entry.made, input_state=state, input_settled=settled)
            self._ledger.finish(place, made)
            return
        else:
            self._ledger.fail(place, outcome.error or "failed")
            if outcome.full:
                self.stopped = "the disk is full"
            elif self._spec.fail_fast and self.stopped is None:
                self.stopped = "a recording failed (--fail-fast)"
        self.worked_on.add(place)


def _exit_code(end: KeyboardInterrupt | SystemExit | None) -> int | None:
    return end.code if isinstance(end, SystemExit) and isinstance(end.code, int) else None


def _state(spec: BatchSpec) -> Path:
    return Path(spec.state) if spec.state is not None else Path(spec.out, STATE)


@contextlib.contextmanager
def _executor(spec: BatchSpec, run: str, lock: Lock, needed: bool) -> Iterator[Executor]:
    """Give what does the work; a cluster is joined only where there is any."""
    if spec.scheduler is None or not needed:
        jobs = spec.jobs or default_jobs()
        threads = spec.threads or _default_threads(spec)
        yield Processes(jobs, threads, spec.retries, spec.patience_s, lock.descriptor)
        return
    from .cluster import Cluster

    path = lock.path.absolute()
    cluster = Cluster(spec.scheduler, spec.retries, spec.patience_s, run, path)
    try:
        yield cluster
    finally:
        cluster.close()


def _default_threads(spec: BatchSpec) -> int:
    """Return the threads of one recording: its share of the cores; on a cluster one, as Dask counts."""
    if spec.scheduler is not None:
        return 1
    return max(1, cores() // (spec.jobs or default_jobs()))


def _clean(spec: BatchSpec, ledger: Ledger, places: set[str]) -> None:
    """Remove what killed workers left beside the outputs of these places, and directories left empty."""
    for folder in {os.path.dirname(place) for place in places}:
        remove_temporaries(os.path.join(spec.out, folder), ledger.mark)
        with contextlib.suppress(OSError):
            while folder:
                os.rmdir(os.path.join(spec.out, folder))
                folder = os.path.dirname(folder)


def _check_place(spec: BatchSpec, ledger: Ledger) -> None:
    """Refuse a ledger kept elsewhere that tells of another directory of outputs."""
    if spec.state is None:
        return
    out, known = os.path.realpath(spec.out), ledger.about(_OUT)
    if known is None:
        ledger.note(_OUT, out)
    elif known != out:
        raise UsageError(
            f"--state {shown(spec.state)} tells of the outputs in {shown(known)}: give each --out its own"
        )


def _check_reports(spec: BatchSpec, ledger: Ledger) -> None:
    if ledger.about(_REPORTED) is not None or spec.overwrite:
        return
    for name in (JSON_REPORT, HTML_REPORT):
        path = os.path.join(spec.out, name)
        if os.path.lexists(path):
            raise OutputError(
                f"{shown(path)}: exists and is not of this batch: move it away, or give --overwrite"
            )


def _write_reports(spec: BatchSpec, report: BatchReport) -> None:
    data = json.dumps(report.data(), ensure_ascii=False, allow_nan=False, indent=1)
    for name, text in ((JSON_REPORT, data + "\n"), (HTML_REPORT, report_page(report))):
        with atomic_output(os.path.join(spec.out, name), overwrite=True) as path:
            path.write_text(text, encoding="utf-8")
