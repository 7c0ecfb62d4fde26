"""Tasks on the workers of a Dask cluster."""

from __future__ import annotations

import asyncio
import concurrent.futures
import contextlib
import logging
import os
import queue
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from .._version import __version__
from ..errors import EndocalError, InputError, UsageError
from ..files.names import shown
from ..jobs.correction import Progress
from .executor import Ended, Event, Moved, Started
from .remote import PassingError, perform_on_worker
from .task import Outcome, Task

_CONNECT_S = 15
# Tasks that wait at the scheduler beyond two for each thread: enough for a cluster that grows by its queue.
_SPARE = 16
_LOOK_EVERY_S = 5.0
_POLL_S = 0.2
# States of a future that has an outcome.
_OVER = ("finished", "error", "cancelled")
# What Dask's client raises without a scheduler: a closed connection, a task or a client that is cancelled.
_GONE = (OSError, RuntimeError, asyncio.CancelledError, concurrent.futures.CancelledError)


class Cluster:
    """The workers of the scheduler at an address, or in a scheduler file (.json).

    Each thread of a worker takes one recording at a time. Dask gives the tasks of a lost worker to others,
    and tries a task ``retries`` times more that failed for a passing reason. ``run`` is the name of this
    run in the file ``lock``, by which a worker knows that it is not over. Raises UsageError without the
    extra ``cluster``, InputError where the scheduler does not answer, or a worker has another endocal or
    does not see the directory of outputs.
    """

    def __init__(self, address: str, retries: int, patience_s: float, run: str, lock: Path) -> None:
        try:
            from distributed import Client
            from distributed.comm.addressing import resolve_address
        except ImportError:
            raise UsageError(
                "--scheduler needs Dask: pip install 'endocal-toolchain[cluster]'"
            ) from None
        _hush()
        self._address, self._retries, self._patience_s = address, retries, patience_s
        self._run, self._lock = run, lock
        where = {"scheduler_file": address} if os.path.isfile(address) else {"address": address}
        try:
            if "address" in where:
                # A client that was made for a wrong address takes half a minute to go.
                resolve_address(address)
            self._client: Any = Client(**where, timeout=_CONNECT_S, set_as_default=False)
        except (OSError, ValueError, TypeError, KeyError) as error:
            reason = str(error).splitlines()[0] if str(error) else type(error).__name__
            raise InputError(f"no Dask scheduler answers at {shown(address)}: {reason}") from None
        try:
            self._check_workers()
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Leave the cluster as it is, and go."""
        self._client.close(timeout=2)

    def describe(self) -> str:
        """Say in a few words what does the work."""
        threads = self._client.nthreads()
        return f"{sum(threads.values())} threads of {len(threads)} Dask workers"

    def run(self, tasks: Iterator[Task]) -> Iterator[Event]:
        """Run the tasks; see Executor."""
        news: queue.SimpleQueue[Any] = queue.SimpleQueue()
        topic = f"endocal-{self._run}"
        self._client.subscribe_topic(topic, lambda event: news.put(event[1]))
        futures: dict[str, Any] = {}
        # Those that had ended, and whose results were lost with their workers: Dask does them again.
        lost: set[str] = set()
        places: dict[str, str] = {}
        room, looked, number = 0, 0.0, 0
        try:
            while True:
                if time.monotonic() - looked > _LOOK_EVERY_S:
                    room = self._room()
                    looked = time.monotonic()
                while len(futures) < room and (task := next(tasks, None)) is not None:
                    key = f"{topic}-{number}"
                    number += 1
                    places[key] = task.place
                    futures[key] = self._submit(key, task, topic)
                    futures[key].add_done_callback(news.put)
                if not futures:
                    return
                for key in [k for k in lost if futures[k].status in _OVER]:
                    lost.discard(key)
                    news.put(futures[key])
                try:
                    item = news.get(timeout=_POLL_S if lost else _LOOK_EVERY_S)
                except queue.Empty:
                    continue
                if isinstance(item, dict):
                    # News of a task may come after its end.
                    if item["key"] in futures:
                        yield _event(places[item["key"]], item)
                elif item.status not in _OVER:
                    lost.add(item.key)
                elif futures.pop(item.key, None) is not None:
                    yield Ended(places[item.key], self._outcome(item, places[item.key]))
        finally:
            # Without a scheduler there is nothing to take back.
            with contextlib.suppress(*_GONE):
                self._client.cancel(list(futures.values()), force=True)
                self._client.unsubscribe_topic(topic)

    def _room(self) -> int:
        """Return how many tasks the scheduler may have."""
        with self._speaking():
            return 2 * sum(self._client.nthreads().values()) + _SPARE

    def _submit(self, key: str, task: Task, topic: str) -> Any:
        # A task that Dask repeats, since its worker was lost, may find its own output there.
        task = replace(task, correction=replace(task.correction, overwrite=True))
        order = (task, topic, key, self._run, str(self._lock), self._patience_s)
        with self._speaking():
            return self._client.submit(
                perform_on_worker, *order, key=key, pure=False, retries=self._retries
            )

    @contextlib.contextmanager
    def _speaking(self) -> Iterator[None]:
        """Say what it means when the scheduler no longer answers."""
        try:
            yield
        except _GONE as error:
            raise InputError(
                f"the Dask scheduler at {shown(self._address)} went away: start the same batch again when"
                " it is back, and it goes on from here"
            ) from error

    def _outcome(self, future: Any, place: str) -> Outcome:
        with self._speaking():
            if future.status == "finished":
                outcome: Outcome = future.result()
                return outcome
            if future.status == "cancelled" or self._client.status != "running":
                raise ConnectionError
            error = future.exception()
        if type(error).__name__ == "KilledWorker":
            return Outcome(
                error=f"{shown(place)}: every worker that took it died, {error.last_worker.address} last"
            )
        if not isinstance(error, PassingError):
            # A worker that has come since the start may be one that nothing can be done on.
            with self._speaking():
                self._check_workers()
        words = (
            str(error) if isinstance(error, EndocalError) else f"{type(error).__name__}: {error}"
        )
        return Outcome(error=words)

    def _check_workers(self) -> None:
        for address, sees in sorted(self._client.run(os.path.exists, str(self._lock)).items()):
            if not sees:
                raise InputError(
                    f"the Dask worker {address} does not see {shown(self._lock.parent)}: files go by shared"
                    " paths"
                )
        # A function of ours would not arrive at a worker that has none or an old endocal.
        answers = self._client.run(eval, "__import__('endocal').__version__", on_error="return")
        for address, answer in sorted(answers.items()):
            if isinstance(answer, ImportError):
                raise InputError(
                    f"the Dask worker {address} has no endocal: install {__version__} there"
                )
            if answer != __version__:
                raise InputError(
                    f"the Dask worker {address} has endocal {answer}, and this is {__version__}: install the"
                    " same on all"
                )


def _hush() -> None:
    """Silence what Dask and its libraries log of lost workers and connections: our own lines say it."""
    names = ["tornado", "asyncio", *logging.root.manager.loggerDict]
    for name in names:
        if name.partition(".")[0] in ("distributed", "tornado", "asyncio"):
            logging.getLogger(name).setLevel(logging.CRITICAL + 1)


def _event(place: str, news: dict[str, Any]) -> Event:
    if "frames" in news:
        return Moved(place, Progress(news["frames"], news["total"], news["seconds"]))
    return Started(place, news["worker"])
