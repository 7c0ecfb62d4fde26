"""What a picture decoder says on standard error, kept from the user's terminal.

libjpeg and libtiff decode what they can of a damaged picture, print a line of their own, and report success.
"""

from __future__ import annotations

import contextlib
import os
import re
import sys
import tempfile
import threading
from collections.abc import Iterator
from typing import Any, BinaryIO

import cv2

# What libjpeg says of its data, in a TIFF too, and what libtiff's decoders say of theirs, once without their
# name. libtiff's other words are of tags that it does not know and of pages that nobody reads.
_DAMAGE = re.compile(
    r"Corrupt JPEG data: |TIFF_Error JPEGLib: |TIFF_(?:Error|Warning) \w*Decode\w*: "
    r"|TIFF_Error (?=Using code not yet in table)"
)
# Some cameras fill up the last few bytes, which does no harm.
_SHORT_FILL = re.compile(r"Corrupt JPEG data: ([1-9]|1[0-6]) extraneous bytes before marker 0xd9")
_STDERR = 2
_lock = threading.Lock()


def _renew_lock() -> None:
    """Leave a forked child a lock that nobody holds: the thread that may have held it is not there."""
    global _lock
    _lock = threading.Lock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_renew_lock)


@contextlib.contextmanager
def decoder_words() -> Iterator[list[str]]:
    """Collect the lines that go to the process's standard error while the block runs, OpenCV's among them.

    Threads take turns. Where there is no standard error, or no place for the words, nothing is collected.
    """
    lines: list[str] = []
    with _lock, contextlib.ExitStack() as stack:
        try:
            kept = os.dup(_STDERR)
            stack.callback(os.close, kept)
            words = stack.enter_context(_nameless_file())
        except OSError:
            yield lines
            return
        if sys.stderr is not None:
            sys.stderr.flush()
        try:
            os.dup2(words.fileno(), _STDERR)
            with _opencv_warns():
                yield lines
        finally:
            os.dup2(kept, _STDERR)
            words.seek(0)
            lines += words.read().decode(errors="replace").splitlines()


def _nameless_file() -> BinaryIO:
    """A file to write to, in memory where that can be: it needs no directory, and no room on a disk.

    Programs that are started meanwhile may hold on to it, and write to it later; nobody has to read that.
    """
    if hasattr(os, "memfd_create"):
        return os.fdopen(os.memfd_create("words"), "w+b")
    return tempfile.TemporaryFile()


def damage_in(lines: list[str]) -> str | None:
    """Return what the lines say is wrong with a picture, in the decoder's words; None for nothing."""
    for line in lines:
        found = _DAMAGE.search(line)
        if found and not _SHORT_FILL.search(line):
            return line[found.end() :]
    return None


@contextlib.contextmanager
def _opencv_warns() -> Iterator[None]:
    """Let OpenCV pass on what libtiff says: the command line silences it, since it talks to the user."""
    logging: Any = cv2.utils.logging
    before = logging.getLogLevel()
    logging.setLogLevel(max(before, logging.LOG_LEVEL_WARNING))
    try:
        yield
    finally:
        logging.setLogLevel(before)
