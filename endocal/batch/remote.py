"""What a Dask worker runs."""

from __future__ import annotations

import threading
import time
from pathlib import Path

from ..errors import EndocalError
from ..jobs.correct import Progress
from ..jobs.threads import limit_threads
from .kernel_cache import use_own_kernel_cache
from .lock import read_holder
from .task import Outcome, Task, perform

_LOOK_EVERY_S = 2.0
_prepared = threading.Event()
_preparing = threading.Lock()


class PassingError(EndocalError):
    """A task failed for a reason that may be gone the next time: Dask tries it again."""


class RunOverError(EndocalError):
    """The run that a task belongs to has ended: nobody waits for it."""


def perform_on_worker(task: Task, topic: str, key: str, run: str, lock: str) -> Outcome:
    """Do a task on this worker and tell the topic of it, for as long as the run lasts.

    Dask cannot end a task that has begun. So the task itself looks whether the batch, or another one after
    it, has written over the run's name: a client that was killed leaves no work behind that would get in
    the way of the next.
    """
    from distributed import get_worker

    worker = get_worker()
    _prepare(task.correction.threads * worker.state.nthreads)
    worker.log_event(topic, {"key": key, "worker": worker.address})
    watch = _Watch(run, Path(lock))

    def tell(progress: Progress) -> None:
        watch.look()
        frames, total, seconds = progress.frames, progress.total, progress.seconds
        worker.log_event(topic, {"key": key, "frames": frames, "total": total, "seconds": seconds})

    watch.look()
    try:
        outcome = perform(task, tell)
    except RunOverError as error:
        return Outcome(error=str(error))
    if outcome.passing:
        raise PassingError(outcome.error)
    return outcome


class _Watch:
    """Looks whether a run is over; it is when its file has said so twice."""

    def __init__(self, run: str, lock: Path) -> None:
        self._run, self._lock = run, lock
        self._next = 0.0
        self._missed = 0

    def look(self) -> None:
        """Raise RunOverError when the run is over."""
        now = time.monotonic()
        if now < self._next:
            return
        self._next = now + _LOOK_EVERY_S
        holder = read_holder(self._lock)
        over = self._lock.exists() and (holder is None or holder.run != self._run)
        self._missed = self._missed + 1 if over else 0
        if self._missed > 1:
            raise RunOverError("the batch that asked for it has ended")


def _prepare(threads: int) -> None:
    """Set up this process, once."""
    with _preparing:
        if not _prepared.is_set():
            limit_threads(threads)
            use_own_kernel_cache()
            _prepared.set()
