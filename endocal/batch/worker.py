"""A worker process: takes tasks from a line to the batch and answers on it, until the line goes dead."""

from __future__ import annotations

import os
import queue
import signal
import sys
import threading
import time
from multiprocessing.connection import Connection
from typing import Any

from ..jobs.threads import limit_threads
from .kernel_cache import use_own_kernel_cache

# So long a recording in work has to take back its temporary file.
_GRACE_S = 5.0


def main() -> None:
    """Serve the line whose descriptor is the first argument, with as many threads as the second says."""
    # Ctrl-C goes to every process of the terminal; the batch says what is to happen then.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _end)
    connection = Connection(int(sys.argv[1]))
    limit_threads(int(sys.argv[2]))
    use_own_kernel_cache()
    tasks: queue.SimpleQueue[Any] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(connection, tasks), daemon=True).start()
    from .task import perform

    while True:
        task = tasks.get()
        _answer(connection, perform(task, lambda progress: _answer(connection, progress)))


def _listen(connection: Connection, tasks: queue.SimpleQueue[Any]) -> None:
    """Queue what comes. A dead line means that nobody waits for the work any more: the process ends."""
    try:
        while True:
            tasks.put(connection.recv())
    except (EOFError, OSError):
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(_GRACE_S)
        os._exit(1)


def _answer(connection: Connection, message: Any) -> None:
    try:
        connection.send(message)
    except OSError:
        # The line is dead: the other thread is about to end us.
        time.sleep(_GRACE_S)


def _end(number: int, frame: object) -> None:
    sys.exit(128 + number)
