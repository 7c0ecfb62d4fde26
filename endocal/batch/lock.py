"""One batch at a time in a directory, whatever becomes of the others."""

from __future__ import annotations

import contextlib
import errno
import json
import os
import socket
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

from ..errors import OutputError
from ..files.names import shown

# What a killed batch left running ends within seconds; so long its lock is waited for.
_PATIENCE_S = 15.0
_POLL_S = 0.1


@dataclass(frozen=True)
class Holder:
    """Who is at work: the run's name, process, machine, and since when (local time)."""

    run: str
    pid: int
    host: str
    since: str


@dataclass(frozen=True)
class Lock:
    """A lock that is held, and its file's descriptor, for processes that are to hold it too."""

    path: Path
    descriptor: int


@contextlib.contextmanager
def hold_lock(path: Path, run: str, name: str, optional: bool = False) -> Iterator[Lock]:
    """Hold the lock while the block runs; OutputError, naming the holder, where another batch has it.

    The operating system holds it (flock) for this process and those that inherit the descriptor, until the
    last of them is gone: no killed batch leaves it behind, and none is let in while an old one's workers
    still write. ``name`` is what messages call the directory of outputs. Where the file system has no locks,
    an ``optional`` one goes without.
    """
    try:
        import fcntl
    except ImportError:  # Windows
        raise OutputError("endocal batch needs the file locks of Linux or macOS") from None
    try:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    except OSError as error:
        raise OutputError(f"{shown(path)}: cannot be written: {error.strerror}") from None
    try:
        patience = time.monotonic() + _PATIENCE_S
        while True:
            try:
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
                break
            except BlockingIOError:
                holder = read_holder(path)
                if time.monotonic() > patience or not _is_gone(holder):
                    raise OutputError(f"{name}: {_describe(holder)}") from None
                time.sleep(_POLL_S)
            except OSError as error:
                if optional and error.errno in (errno.ENOLCK, errno.EOPNOTSUPP):
                    break
                reason = (
                    "its file system has no locks"
                    if error.errno == errno.ENOLCK
                    else error.strerror
                )
                raise OutputError(
                    f"{name}: cannot be locked: {reason}; --state DIR keeps lock and ledger elsewhere"
                ) from None
        _write_holder(descriptor, run)
        try:
            yield Lock(path, descriptor)
        finally:
            # Workers on other machines read here that their run is over.
            os.ftruncate(descriptor, 0)
    finally:
        os.close(descriptor)


def read_holder(path: Path) -> Holder | None:
    """Return who holds a lock, as far as its file tells."""
    try:
        return Holder(**json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError):
        return None


def _write_holder(descriptor: int, run: str) -> None:
    now = time.strftime("%Y-%m-%d %H:%M:%S")
    holder = Holder(run, os.getpid(), socket.gethostname(), now)
    os.ftruncate(descriptor, 0)
    os.pwrite(descriptor, (json.dumps(asdict(holder)) + "\n").encode(), 0)
    # On a network drive, others see it only then.
    os.fsync(descriptor)


def _is_gone(holder: Holder | None) -> bool:
    """Tell whether the batch that took the lock has ended, so that only its workers can still have it."""
    if holder is None:
        return True
    if holder.host != socket.gethostname():
        return False
    try:
        os.kill(holder.pid, 0)
    except ProcessLookupError:
        return True
    except PermissionError:
        return False
    return False


def _describe(holder: Holder | None) -> str:
    who = (
        "" if holder is None else f" (process {holder.pid} on {holder.host}, since {holder.since})"
    )
    return f"another batch is at work here{who}: wait for its end, or give another --out"
