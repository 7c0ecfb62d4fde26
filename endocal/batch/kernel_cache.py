"""A kernel cache for each process: PoCL's cache is not safe for several at once."""

from __future__ import annotations

import contextlib
import itertools
import os
from pathlib import Path

_POCL = "POCL_CACHE_DIR"
_held: list[int] = []


def use_own_kernel_cache() -> None:
    """Let PoCL, which is not loaded yet, keep its kernels where no other process does.

    Processes that build into one cache have crashed or failed to build
    (https://github.com/pocl/pocl/issues/430, /1480). The caches are numbered, and a process takes the first
    that is free, so that later runs find their kernels built. What the environment says goes first.
    """
    base = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    if _POCL in os.environ:
        return
    # Without a place to write, PoCL does as it always does.
    with contextlib.suppress(OSError, ImportError):
        import fcntl

        for number in itertools.count():
            folder = Path(base, "endocal", "kernels", str(number))
            folder.mkdir(parents=True, exist_ok=True)
            descriptor = os.open(folder / "lock", os.O_RDWR | os.O_CREAT, 0o600)
            try:
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                os.close(descriptor)
                continue
            # Held until the process ends.
            _held.append(descriptor)
            os.environ[_POCL] = str(folder)
            return
