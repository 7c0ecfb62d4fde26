"""One batch at a time, and no lock that outlives its holders."""

from __future__ import annotations

import multiprocessing
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from endocal.batch.lock import hold_lock, read_holder
from endocal.errors import OutputError

HOLD = """
import sys, time
from pathlib import Path
from endocal.batch.lock import hold_lock
with hold_lock(Path(sys.argv[1]), "other", "out"):
    print("held", flush=True)
    time.sleep(60)
"""


def test_the_other_batch_is_named(tmp_path: Path) -> None:
    path = tmp_path / "lock"
    with subprocess.Popen(
        [sys.executable, "-c", HOLD, str(path)], stdout=subprocess.PIPE, text=True
    ) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == "held\n"
        began = time.monotonic()
        with (
            pytest.raises(OutputError, match=rf"out: another batch .*process {other.pid} on"),
            hold_lock(path, "mine", "out"),
        ):
            pass
        # At once: there is nothing to wait for.
        assert time.monotonic() - began < 5
        other.kill()
        other.wait()
    with hold_lock(path, "mine", "out"):
        holder = read_holder(path)
        assert holder is not None
        assert (holder.run, holder.pid) == ("mine", os.getpid())
    assert read_holder(path) is None


def test_what_a_killed_batch_left_running_is_waited_for(tmp_path: Path) -> None:
    """A worker holds the lock on for a moment, as one does that takes back its temporary file."""
    path = tmp_path / "lock"
    context = multiprocessing.get_context("fork")

    def batch_with_worker() -> None:
        with hold_lock(path, "killed", "out"):
            if os.fork() == 0:
                time.sleep(0.7)
                os._exit(0)
            os.kill(os.getpid(), 9)

    process = context.Process(target=batch_with_worker)
    process.start()
    process.join()
    assert process.exitcode == -9
    began = time.monotonic()
    with hold_lock(path, "next", "out"):
        assert time.monotonic() - began > 0.2
