"""What a Dask worker runs."""

from __future__ import annotations

import os
import threading
import time
from pathlib import Path

from .._version import __version__
from ..errors import EndocalError
from ..jobs.correction import Progress
from ..jobs.threads import limit_threads
from .kernel_cache import use_own_kernel_cache
from .lock import read_holder
from .task import Outcome, Task, perform, stuck

_LOOK_EVERY_S = 2.0
_prepared = threading.Event()
_preparing = threading.Lock()


class PassingError(EndocalError):
    """A task failed for a reason that may be gone the next time: Dask tries it again."""


class WorkerError(EndocalError):
    """This worker cannot do what it was asked for, whatever the recording."""


class RunOverError(Exception):
    """The run that a task belongs to has ended: nobody waits for it."""


def perform_on_worker(
    task: Task, topic: str, key: str, run: str, lock: str, patience_s: float
) -> Outcome:
    """Do a task on this worker and tell the topic of it, for as long as the run lasts.

    Dask cannot end a task that has begun. So the task itself looks whether the batch, or another one after
    it, has written over the run's name: a client that was killed leaves no work behind that would get in
    the way of the next. It also gives itself up when it has not moved on by a frame for ``patience_s``.
    Raises PassingError where another try may do, WorkerError for another version of endocal and where
    the directory of outputs cannot be seen from here.
    """
    if task.version != __version__:
        raise WorkerError(f"this worker has endocal {__version__}, and the batch {task.version}")
    if not os.path.exists(lock):
        raise WorkerError(f"this worker does not see {lock}")
    from distributed import get_worker

    worker = get_worker()
    _prepare(task.correction.threads * worker.state.nthreads)
    worker.log_event(topic, {"key": key, "worker": worker.address})
    watch = _Watch(run, Path(lock), task.correction.input, patience_s)

    def tell(progress: Progress) -> None:
        watch.look(progress.frames)
        frames, total, seconds = progress.frames, progress.total, progress.seconds
        worker.log_event(topic, {"key": key, "frames": frames, "total": total, "seconds": seconds})

    try:
        outcome = perform(task, tell)
    except RunOverError as error:
        return Outcome(error=str(error))
    if outcome.passing:
        raise PassingError(outcome.error)
    return outcome


class _Watch:
    """Looks whether a run is over, which it is when its file has said so twice, and a recording stuck."""

    def __init__(self, run: str, lock: Path, source: str, patience_s: float) -> None:
        self._run, self._lock, self._source = run, lock, source
        self._patience_s = patience_s
        self._next = 0.0
        self._missed = 0
        self._frames, self._moved = 0, time.monotonic()

    def look(self, frames: int) -> None:
        """Raise RunOverError when the run is over, and EndocalError when the recording is stuck."""
        now = time.monotonic()
        if frames != self._frames:
            self._frames, self._moved = frames, now
        if now - self._moved > self._patience_s:
            raise EndocalError(stuck(self._source, self._patience_s))
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
