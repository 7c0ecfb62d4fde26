"""Standard output as a pipe that does not wait."""

from __future__ import annotations

import os
import threading
import time

from endocal.jobs.pipe import PipeOutput


def test_a_pipe_that_does_not_wait_is_waited_for() -> None:
    """More than a pipe holds, to a reader that comes late."""
    data = os.urandom(1 << 20)
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    parts: list[bytes] = []

    def read() -> None:
        time.sleep(0.1)
        with open(reading, "rb") as file:
            parts.append(file.read())

    reader = threading.Thread(target=read)
    reader.start()
    with open(writing, "wb", buffering=0) as file:
        assert PipeOutput(file).write(data) == len(data)  # type: ignore[arg-type]
    reader.join()
    assert parts == [data]
