"""What a picture decoder says on standard error, kept from the user's terminal.

libjpeg decodes what it can of a damaged picture, prints a line of its own, and reports success.
"""

from __future__ import annotations

import contextlib
import os
import re
import sys
import tempfile
import threading
from collections.abc import Iterator

_DAMAGE = "Corrupt JPEG data: "
# Some cameras fill up the last few bytes, which does no harm.
_SHORT_FILL = re.compile(r"Corrupt JPEG data: ([1-9]|1[0-6]) extraneous bytes before marker 0xd9")
_STDERR = 2
_lock = threading.Lock()


@contextlib.contextmanager
def decoder_words() -> Iterator[list[str]]:
    """Collect the lines that go to the process's standard error while the block runs.

    Threads take turns. Where there is no standard error, nothing is collected.
    """
    lines: list[str] = []
    with _lock, tempfile.TemporaryFile() as file:
        try:
            kept = os.dup(_STDERR)
        except OSError:
            yield lines
            return
        if sys.stderr is not None:
            sys.stderr.flush()
        os.dup2(file.fileno(), _STDERR)
        try:
            yield lines
        finally:
            os.dup2(kept, _STDERR)
            os.close(kept)
            file.seek(0)
            lines += file.read().decode(errors="replace").splitlines()


def damage_in(lines: list[str]) -> str | None:
    """Return what the lines say is wrong with a picture, in the decoder's words; None for nothing."""
    for line in lines:
        if line.startswith(_DAMAGE) and not _SHORT_FILL.match(line):
            return line.removeprefix(_DAMAGE)
    return None
