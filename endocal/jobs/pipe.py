"""Standard input and output as a picture or a video comes and goes through them.

Both go past Python's buffers: a thread that waits for a pipe inside one would hold its lock, and the
process could not end.
"""

from __future__ import annotations

import io
import os
import select
import stat
import sys
import threading
from typing import BinaryIO

PIPE = "-"
# What to do about a pipe through which nothing came.
NOTHING_CAME = "see what the command before the pipe says"

# How long a reader that waits for input takes to notice that nobody wants it any more, s.
_NOTICE_S = 0.1
_CHUNK = 1 << 20


class PipeInput:
    """A pipe, standard input by default, whose first bytes can be looked at and still be read."""

    def __init__(self, file: BinaryIO | None = None) -> None:
        self._file: BinaryIO = sys.stdin.buffer if file is None else file
        self._descriptor = _descriptor(self._file)
        self._head = b""
        self._stopped = threading.Event()

    def peek(self, size: int) -> bytes:
        """Return the first ``size`` bytes, or all there are."""
        parts, missing = [self._head], size - len(self._head)
        while missing > 0 and (more := self._next(missing)):
            parts.append(more)
            missing -= len(more)
        self._head = b"".join(parts)
        return self._head[:size]

    def read(self, size: int = -1) -> bytes:
        """Read up to ``size`` bytes, as many as have come; all to the end where it is negative."""
        if size < 0:
            parts = []
            while part := self.read(_CHUNK):
                parts.append(part)
            return b"".join(parts)
        if self._head:
            head, self._head = self._head[:size], self._head[size:]
            return head
        return self._next(size)

    def stop(self) -> None:
        """Let a read that waits in another thread end, as if the input had."""
        self._stopped.set()

    def _next(self, size: int) -> bytes:
        if self._descriptor is None:
            return self._file.read(size)
        while not self._stopped.is_set():
            ready, _, _ = select.select([self._descriptor], [], [], _NOTICE_S)
            if ready:
                return os.read(self._descriptor, size)
        return b""


class PipeOutput:
    """Standard output for a muxer: it is written from front to end, also where it is a file."""

    def __init__(self, file: BinaryIO | None = None) -> None:
        self._file: BinaryIO = sys.stdout.buffer if file is None else file
        self._file.flush()
        self._descriptor = _descriptor(self._file)

    def write(self, data: bytes) -> int:
        """Pass the bytes on at once."""
        if self._descriptor is None:
            self._file.write(data)
            return len(data)
        rest = memoryview(data)
        while rest:
            try:
                rest = rest[os.write(self._descriptor, rest) :]
            except BlockingIOError:
                # A pipe that its owner has told not to wait, which holds for all who write to it.
                select.select([], [self._descriptor], [], _NOTICE_S)
        return len(data)


def open_input(path: str) -> str | PipeInput:
    """Return what an input is read through: standard input for ``-``, a named pipe, else the path itself.

    A named pipe, as the shell makes of ``<(command)``, can be read but once, and so is not looked at first.
    """
    if path == PIPE:
        return PipeInput()
    try:
        is_pipe = stat.S_ISFIFO(os.stat(path).st_mode)
        # It stays open as long as the process: what waits in it belongs to nobody else.
        return PipeInput(open(path, "rb", buffering=0)) if is_pipe else path
    except (OSError, ValueError):
        return path


def _descriptor(file: BinaryIO) -> int | None:
    """Return the file's descriptor, None where it only pretends to be a file."""
    try:
        return file.fileno()
    except (AttributeError, io.UnsupportedOperation):
        return None
