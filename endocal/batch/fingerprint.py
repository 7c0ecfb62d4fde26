"""Whether a file is still the same: by its SHA-256, and by a look at what the file system says of it."""

from __future__ import annotations

import hashlib
import os
import time
from collections.abc import Callable
from dataclasses import dataclass

_BLOCK = 1 << 20
# Two changes within this many seconds may leave one timestamp: two seconds on FAT, some on network drives.
_SETTLED_S = 3.0


@dataclass(frozen=True)
class FileState:
    """What a file system says of a file: size in bytes, times in ns, inode number."""

    size: int
    mtime_ns: int
    ctime_ns: int
    inode: int

    @classmethod
    def of(cls, path: str) -> FileState:
        """Look at a file; OSError where it is not there."""
        seen = os.stat(path)
        return cls(seen.st_size, seen.st_mtime_ns, seen.st_ctime_ns, seen.st_ino)

    def is_settled(self, now: float | None = None) -> bool:
        """Tell whether a later change is bound to show in the times.

        The kernel sets ctime at every change of content or names, and no program can set it back, so that
        it shows even a change that restores mtime. Only a change within the clock's own step might not.
        """
        newest = max(self.mtime_ns, self.ctime_ns) / 1e9
        return newest < (time.time() if now is None else now) - _SETTLED_S


def sha256(path: str, tell: Callable[[int], None] = lambda count: None) -> str:
    """Return the SHA-256 of a file's bytes in hex; ``tell`` is given the bytes read so far."""
    digest, count = hashlib.sha256(), 0
    block = bytearray(_BLOCK)
    view = memoryview(block)
    with open(path, "rb", buffering=0) as file:
        while read := file.readinto(block):
            digest.update(view[:read])
            count += read
            tell(count)
    return digest.hexdigest()


def combined(digests: list[str]) -> str:
    """Return one digest for several: their own where there is only one."""
    return (
        digests[0] if len(digests) == 1 else hashlib.sha256("\n".join(digests).encode()).hexdigest()
    )
