"""How a batch is watched: live on a terminal, as JSON lines elsewhere, or not at all."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from .options import note

if TYPE_CHECKING:
    from ..batch.executor import Event
    from ..batch.plan import Plan
    from ..batch.report import BatchReport

# Names longer than this are shown by their end.
_NAME = 40


class QuietView:
    """Says nothing but what failed, at once."""

    speaks_json = False

    def planned(self, plan: Plan, workers: str) -> None:
        """Say what a manifest names in vain."""
        for text in plan.missing:
            self._fail(text)

    def happened(self, event: Event) -> None:
        """Say what failed."""
        from ..batch.executor import Ended

        if isinstance(event, Ended) and event.outcome.error is not None:
            self._fail(event.outcome.error)

    def ended(self, report: BatchReport) -> None:
        """Leave the last word to the command."""

    def _fail(self, text: str) -> None:
        note(plain(f"failed: {text}"))


class JsonView:
    """Writes an event a line on standard error."""

    speaks_json = True

    def planned(self, plan: Plan, workers: str) -> None:
        """Tell what is to be done, and what is not."""
        from ..batch.plan import LEAVE

        self._write(event="plan", recordings=len(plan.steps), todo=len(plan.todo), workers=workers)
        for text in plan.notes:
            self._write(event="note", text=text)
        for text in plan.missing:
            self._write(event="missing", reason=text)
        for step in plan.steps:
            if step.action == LEAVE:
                self._write(event="left", output=step.recording.place, reason=step.reason)

    def happened(self, event: Event) -> None:
        """Tell of the start and the end of a recording."""
        from ..batch.executor import Ended, Started

        if isinstance(event, Started):
            self._write(event="start", output=event.place, worker=event.worker)
        elif isinstance(event, Ended):
            outcome = event.outcome
            if outcome.made is not None:
                facts = outcome.made.report
                seconds = round(facts["seconds"], 3)
                self._write(
                    event="done", output=event.place, frames=facts["frames"], seconds=seconds
                )
                for text in facts["warnings"]:
                    self._write(event="warning", output=event.place, text=text)
            elif outcome.error is not None:
                self._write(event="failed", output=event.place, reason=outcome.error)
            else:
                self._write(event="unchanged", output=event.place)

    def ended(self, report: BatchReport) -> None:
        """Tell how it came out."""
        data = report.data()
        self._write(
            event="end",
            **data["counts"],
            seconds=data["seconds"],
            interrupted=report.interrupted,
            stopped=report.stopped,
        )

    def _write(self, **values: Any) -> None:
        line = {k: escaped(v) if isinstance(v, str) else v for k, v in values.items()}
        sys.stderr.write(json.dumps(line, ensure_ascii=False) + "\n")
        sys.stderr.flush()


class LiveView:
    """A bar for each recording in work, one for all, and what failed above them."""

    speaks_json = False

    def __init__(self) -> None:
        from rich.console import Console, Group
        from rich.live import Live
        from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

        self._console = Console(stderr=True)
        text = TextColumn("{task.description}")
        self._each = Progress(
            text, BarColumn(20), TextColumn("{task.fields[state]}"), console=self._console
        )
        # By bytes, since nobody has counted the frames of what is to come.
        self._all = Progress(
            text,
            BarColumn(40),
            TextColumn("{task.percentage:.0f}%"),
            TextColumn("{task.fields[state]}"),
            TimeRemainingColumn(),
            console=self._console,
        )
        self._live = Live(
            Group(self._each, self._all),
            console=self._console,
            refresh_per_second=4,
            transient=True,
        )
        self._bars: dict[str, Any] = {}
        self._sizes: dict[str, int] = {}
        self._parts: dict[str, float] = {}
        self._done = self._failed = self._total = 0
        self._whole: Any = None

    def start(self) -> None:
        """Begin to show."""
        self._live.start()

    def stop(self) -> None:
        """Take the bars away."""
        self._live.stop()

    def planned(self, plan: Plan, workers: str) -> None:
        """Show what is to be done."""
        from ..batch.plan import LEAVE

        todo = plan.todo
        self._say(f"{len(todo)} of {len(plan.steps)} recordings have work; {workers}")
        for text in plan.notes:
            self._say(f"note: {text}")
        for text in plan.missing:
            self._say(f"failed: {text}")
        for step in plan.steps:
            if step.action == LEAVE:
                self._say(f"left alone: {step.recording.place!r} {step.reason}")
        for step in todo:
            with contextlib.suppress(OSError):
                self._sizes[step.recording.place] = os.stat(step.recording.source).st_size
        self._total = len(todo)
        if todo:
            total = sum(self._sizes.values()) or 1
            self._whole = self._all.add_task("all", total=total, state="")
            self._show_state()

    def happened(self, event: Event) -> None:
        """Move the bars."""
        from ..batch.executor import Moved, Started

        place = event.place
        if isinstance(event, Started):
            if place not in self._bars:
                self._bars[place] = self._each.add_task(_short(place), total=None, state="")
        elif isinstance(event, Moved):
            self._move(place, event.progress)
        else:
            if place in self._bars:
                self._each.remove_task(self._bars.pop(place))
            self._parts[place] = 1.0
            self._done += event.outcome.error is None
            if event.outcome.error is not None:
                self._failed += 1
                self._say(f"failed: {event.outcome.error}")
        self._show_state()

    def ended(self, report: BatchReport) -> None:
        """Leave the last word to the command."""

    def _move(self, place: str, progress: Any) -> None:
        if place not in self._bars:
            return
        rate = progress.frames / progress.seconds if progress.seconds else 0.0
        state = f"{progress.frames} frames, {rate:.0f} fps" if progress.frames else "reading"
        total, frames = progress.total, progress.frames
        self._each.update(self._bars[place], total=total, completed=frames, state=state)
        if total:
            self._parts[place] = min(1.0, frames / total)

    def _show_state(self) -> None:
        if self._whole is None:
            return
        failed = f", {self._failed} failed" if self._failed else ""
        state = f"{self._done + self._failed}/{self._total} recordings{failed}"
        moved = sum(self._sizes.get(p, 0) * part for p, part in self._parts.items())
        self._all.update(self._whole, completed=moved, state=state)

    def _say(self, text: str) -> None:
        self._console.print(plain(f"endocal: {text}"), markup=False, highlight=False)


@contextlib.contextmanager
def batch_view(quiet: bool) -> Iterator[QuietView | JsonView | LiveView]:
    """Give the view that suits standard error, and take it down at the end."""
    if quiet:
        yield QuietView()
        return
    if not sys.stderr.isatty():
        yield JsonView()
        return
    view = LiveView()
    view.start()
    try:
        yield view
    finally:
        view.stop()


def summary(report: BatchReport) -> str:
    """Say in one line how a batch came out."""
    from ..batch.recording import HTML_REPORT
    from ..report.numbers import duration

    total = len(report.lines) + len(report.missing)
    words = [
        f"{report.count('done')} of {total} recordings are done ({report.done_now} by this run)"
    ]
    if report.failures:
        words.append(f"{report.failures} failed")
    if report.count("left"):
        words.append(
            f"{report.count('left')} left alone, since their outputs are not of this batch"
        )
    if report.count("open"):
        words.append(f"{report.count('open')} not done yet")
    if report.stopped is not None:
        words.append(f"stopped: {report.stopped}")
    place = os.path.join(report.out, HTML_REPORT)
    return plain(f"{', '.join(words)}, in {duration(report.seconds)}: see {place}")


def missing(plan: Plan) -> str:
    """Say how many recordings are not there, of those that a manifest names."""
    count = len(plan.missing)
    return (
        f"{count} recording{'s are' if count > 1 else ' is'} missing, which a run lists as failed"
    )


def terminated(exit_code: int) -> str:
    """Say which signal ended a batch."""
    return f"ended by {signal.Signals(exit_code - 128).name}"


def plain(text: str) -> str:
    """Return text that can be printed: on one line, what is no Unicode escaped."""
    return " ".join(escaped(text).splitlines())


def escaped(text: str) -> str:
    """Return text that is Unicode: bytes of file names that are none are escaped."""
    return text.encode(errors="backslashreplace").decode()


def _short(place: str) -> str:
    # Names are shown as they are: rich would take square brackets in one for markup.
    name = plain(place if len(place) <= _NAME else f"…{place[-_NAME:]}")
    return name.replace("[", r"\[")
