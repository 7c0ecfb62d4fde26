"""A batch within this process: what it decides and records, without the processes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from endocal.batch import run as run_module
from endocal.batch.executor import Ended, Event, Started
from endocal.batch.plan import Plan
from endocal.batch.recording import BatchSpec
from endocal.batch.report import BatchReport
from endocal.batch.run import preview_batch, run_batch
from endocal.batch.task import Task, perform
from tests.jobs.lenses import calibration
from tests.video.clips import Clip


class InProcess:
    """An executor that does one task after the other, here."""

    def __init__(self, *arguments: Any) -> None:
        pass

    def describe(self) -> str:
        return "this process"

    def run(self, tasks: Iterator[Task]) -> Iterator[Event]:
        for task in tasks:
            yield Started(task.place, "here")
            yield Ended(task.place, perform(task))


@dataclass
class Seen:
    """A watch that keeps what it sees."""

    plan: Plan | None = None
    ended: dict[str, str | None] = field(default_factory=dict)

    def planned(self, plan: Plan, workers: str) -> None:
        self.plan = plan

    def happened(self, event: Event) -> None:
        if isinstance(event, Ended):
            self.ended[event.place] = event.outcome.error


@dataclass
class Batch:
    """A folder with two clips and a calibration, and batches over it."""

    folder: Path

    @property
    def out(self) -> Path:
        return self.folder / "out"

    def spec(self, **options: Any) -> BatchSpec:
        options.setdefault("correction", {"device": "numpy"})
        options.setdefault("calibration", str(self.folder / "cal.toml"))
        options.setdefault("recursive", True)
        sources = options.pop("sources", (str(self.folder / "raw"),))
        return BatchSpec(sources, str(self.out), **options)

    def run(self, **options: Any) -> BatchReport:
        return run_batch(self.spec(**options), Seen())

    def did(self, **options: Any) -> dict[str, str | None]:
        """Run a batch and return what it worked on, with the error of each."""
        seen = Seen()
        run_batch(self.spec(**options), seen)
        return seen.ended


def make_batch(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Batch:
    """Make the folder, and let batches run in this process."""
    monkeypatch.setattr(run_module, "Processes", InProcess)
    (folder / "raw" / "deep").mkdir(parents=True)
    for name in ("a.mkv", "deep/b.mkv"):
        Clip(frames=3).make(folder / "raw" / name)
    calibration(folder / "cal.toml", -1.5e-4)
    return Batch(folder)


Maker = Callable[[], Batch]


def actions(batch: Batch, **options: Any) -> dict[str, tuple[str, str]]:
    plan = preview_batch(batch.spec(**options))
    return {s.recording.place: (s.action, s.reason) for s in plan.steps}
