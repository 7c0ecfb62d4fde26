"""Tasks on processes of this machine."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import replace
from multiprocessing.connection import Connection, wait

from ..jobs.correction import Progress
from .executor import Ended, Event, Moved, Started
from .task import Outcome, Task, stuck

# A worker that has done so many gives way to a fresh one, in case that a library keeps memory.
_RECORDINGS_PER_PROCESS = 200
_PATIENCE_S = 10.0
_LOOK_EVERY_S = 10.0
_COMMAND = "from endocal.batch.worker import main; main()"


class Processes:
    """``jobs`` worker processes, each with ``threads`` threads, started as they are needed and kept warm.

    They hold the lock with us (``lock`` is its descriptor), and end when we do, however that is. A process
    that dies takes only its own recording along, which is tried ``retries`` times more. One whose recording
    has not moved on by a frame for ``patience_s`` seconds is ended, and the recording fails.
    """

    def __init__(self, jobs: int, threads: int, retries: int, patience_s: float, lock: int) -> None:
        self._jobs = jobs
        self._threads = threads
        self._retries = retries
        self._patience_s = patience_s
        self._lock = lock

    def describe(self) -> str:
        """Say in a few words what does the work."""
        words = "1 process" if self._jobs == 1 else f"{self._jobs} processes"
        return f"{words}, {self._threads} thread{'s' * (self._threads > 1)} each"

    def run(self, tasks: Iterator[Task]) -> Iterator[Event]:
        """Run the tasks; see Executor."""
        workers: list[_Worker] = []
        again: list[Task] = []
        attempts: dict[str, int] = {}
        try:
            while True:
                while sum(w.task is not None for w in workers) < self._jobs:
                    task = again.pop() if again else next(tasks, None)
                    if task is None:
                        break
                    yield self._hand_out(task, workers)
                busy = {w.connection: w for w in workers if w.task is not None}
                if not busy:
                    return
                for worker in busy.values():
                    worker.end_if_stuck(self._patience_s)
                for connection in wait(list(busy), min(_LOOK_EVERY_S, self._patience_s)):
                    assert isinstance(connection, Connection)
                    worker = busy[connection]
                    task = worker.task
                    assert task is not None
                    message = worker.receive()
                    if isinstance(message, Progress):
                        yield Moved(task.place, message)
                        continue
                    if worker.is_worn:
                        workers.remove(worker)
                        worker.close()
                    tried = attempts[task.place] = attempts.get(task.place, 0) + 1
                    if message.passing and tried <= self._retries:
                        # Its output may be there already, though nobody said so.
                        order = replace(task.correction, overwrite=True)
                        again.append(replace(task, correction=order))
                    else:
                        yield Ended(task.place, message)
        finally:
            for worker in workers:
                worker.hang_up()
            for worker in workers:
                worker.close()

    def _hand_out(self, task: Task, workers: list[_Worker]) -> Event:
        idle = [w for w in workers if w.task is None]
        if not idle:
            idle.append(_Worker(self._threads, self._lock))
            workers.append(idle[0])
        idle[0].send(task)
        return Started(task.place, f"process {idle[0].pid}")


class _Worker:
    """One process, the line to it, and what it said on stderr."""

    def __init__(self, threads: int, lock: int) -> None:
        ours, theirs = socket.socketpair()
        self._said = tempfile.TemporaryFile()  # noqa: SIM115
        with theirs:
            descriptors = (theirs.fileno(), lock)
            arguments = [str(theirs.fileno()), str(threads)]
            self._process = subprocess.Popen(
                # -P: what happens to lie in the working directory is not imported.
                [sys.executable, "-P", "-c", _COMMAND, *arguments],
                pass_fds=descriptors,
                stdin=subprocess.DEVNULL,
                stdout=self._said,
                stderr=self._said,
            )
        self.connection = Connection(ours.detach())
        self.task: Task | None = None
        self._count = 0
        self._is_dead = False
        self._frames, self._moved = 0, 0.0
        self._stuck_s: float | None = None

    @property
    def pid(self) -> int:
        return self._process.pid

    @property
    def is_worn(self) -> bool:
        return self._is_dead or self._count >= _RECORDINGS_PER_PROCESS

    def send(self, task: Task) -> None:
        self.task = task
        self._frames, self._moved = 0, time.monotonic()
        # A process that is dead already shows when its answer is read.
        with contextlib.suppress(BrokenPipeError):
            self.connection.send(task)

    def receive(self) -> Progress | Outcome:
        """Return what the worker says, or the outcome that it died."""
        try:
            message: Progress | Outcome = self.connection.recv()
        except (EOFError, ConnectionResetError):
            self._is_dead = True
            message = Outcome(error=self._last_words(), passing=self._stuck_s is None)
        if isinstance(message, Outcome):
            self.task = None
            self._count += 1
        elif message.frames != self._frames:
            self._frames, self._moved = message.frames, time.monotonic()
        return message

    def end_if_stuck(self, patience_s: float) -> None:
        """Kill the process if its recording has not moved on for so long; that shows when it is read."""
        if time.monotonic() - self._moved > patience_s:
            self._stuck_s = patience_s
            self._process.kill()

    def hang_up(self) -> None:
        """Let the worker end, and remove what it has begun."""
        self.connection.close()

    def close(self) -> None:
        self.hang_up()
        try:
            self._process.wait(_PATIENCE_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._said.close()

    def _last_words(self) -> str:
        assert self.task is not None
        code = self._process.wait()
        if self._stuck_s is not None:
            return stuck(self.task.correction.input, self._stuck_s)
        name = signal.Signals(-code).name if code < 0 else f"exit code {code}"
        if code == -signal.SIGKILL:
            name += ", which may be for want of memory: fewer --jobs need less"
        size = os.fstat(self._said.fileno()).st_size
        self._said.seek(max(0, size - 2000))
        lines = self._said.read().decode(errors="replace").strip().splitlines()
        said = f": {lines[-1].strip()}" if lines else ""
        return f"{self.task.correction.input}: its process died ({name}){said}"
