"""How many recordings a machine can work on at once."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

# A job takes about 340 MiB at 1920x1080 and 720 MiB at 3840x2160; a whole one leaves room for the disk cache.
_MEMORY_PER_JOB = 1 << 30
_CGROUP = Path("/sys/fs/cgroup")


def cores() -> int:
    """Return the cores that this process may use: its affinity, and the container's share."""
    try:
        count = len(os.sched_getaffinity(0))
    except AttributeError:  # macOS
        count = os.cpu_count() or 1
    with contextlib.suppress(OSError, ValueError):
        quota, period = (_CGROUP / "cpu.max").read_text().split()
        count = min(count, max(1, round(int(quota) / int(period))))
    return count


def memory() -> int | None:
    """Return the bytes of memory that this process may use; None where that is not known."""
    limits = []
    with contextlib.suppress(OSError, ValueError, AttributeError):
        limits.append(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    with contextlib.suppress(OSError, ValueError):
        limits.append(int((_CGROUP / "memory.max").read_text()))
    return min(limits, default=None)


def default_jobs() -> int:
    """Return how many recordings to work on at once: one a core, as far as the memory goes.

    It depends on the machine and not on what is to be done or on what else runs: a second run is to encode
    as the first one did, and some encoders write other bytes for another number of threads.
    """
    room = memory()
    by_memory = cores() if room is None else room // _MEMORY_PER_JOB
    return max(1, min(cores(), by_memory))
