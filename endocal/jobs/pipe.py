"""Standard input and output as a picture or a video comes and goes through them."""

from __future__ import annotations

import sys
from typing import BinaryIO


class PipeInput:
    """Standard input whose first bytes can be looked at and are still there to be read."""

    name = "standard input"

    def __init__(self, file: BinaryIO | None = None) -> None:
        self._file: BinaryIO = sys.stdin.buffer if file is None else file
        self._head = b""

    def peek(self, size: int) -> bytes:
        """Return the first ``size`` bytes, or all there are."""
        while len(self._head) < size and (more := self._file.read(size - len(self._head))):
            self._head += more
        return self._head[:size]

    def read(self, size: int = -1) -> bytes:
        """Read up to ``size`` bytes, as many as have come; all to the end where it is negative."""
        if size < 0:
            head, self._head = self._head, b""
            return head + self._file.read()
        if self._head:
            head, self._head = self._head[:size], self._head[size:]
            return head
        # One system call, so that a live source is not held back until a whole buffer has come.
        read1 = getattr(self._file, "read1", self._file.read)
        return read1(size)
