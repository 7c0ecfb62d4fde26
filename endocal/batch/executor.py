"""What runs the tasks: the protocol that local processes and a cluster share."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

from ..jobs.correction import Progress
from .task import Outcome, Task


@dataclass(frozen=True)
class Started:
    """A worker has taken up a task."""

    place: str
    worker: str


@dataclass(frozen=True)
class Moved:
    """A task has come so far; no frames yet while its input is read for its digest."""

    place: str
    progress: Progress


@dataclass(frozen=True)
class Ended:
    """A task has ended, for good."""

    place: str
    outcome: Outcome


Event = Started | Moved | Ended


class Executor(Protocol):
    """Runs tasks, as many at once as it has room for."""

    def describe(self) -> str:
        """Say in a few words what does the work."""
        ...

    def run(self, tasks: Iterator[Task]) -> Iterator[Event]:
        """Take tasks as there is room for them, and yield what happens to each, until all have ended.

        ``tasks`` may end early; what was taken is finished. Closing the iterator stops all at once.
        """
        ...
