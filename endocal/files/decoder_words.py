"""What a picture decoder says on standard error, kept from the user's terminal.

libjpeg and libtiff decode what they can of a damaged picture, print a line of their own, and report success.
"""

from __future__ import annotations

import contextlib
import os
import re
import sys
import threading
from collections.abc import Iterator
from typing import Any

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
_CHUNK = 1 << 16
_END = b"\0no more words\0"
_lock = threading.Lock()


@contextlib.contextmanager
def decoder_words() -> Iterator[list[str]]:
    """Collect the lines that go to the process's standard error while the block runs, OpenCV's among them.

    Threads take turns. Where there is no standard error, nothing is collected.
    """
    lines: list[str] = []
    with _lock:
        try:
            kept = os.dup(_STDERR)
        except OSError:
            yield lines
            return
        said = bytearray()
        outlet, inlet = os.pipe()
        listener = threading.Thread(target=_listen, args=(outlet, said), daemon=True)
        listener.start()
        if sys.stderr is not None:
            sys.stderr.flush()
        os.dup2(inlet, _STDERR)
        try:
            with _opencv_warns():
                yield lines
        finally:
            os.dup2(kept, _STDERR)
            os.write(inlet, _END)
            listener.join()
            for descriptor in (kept, inlet, outlet):
                os.close(descriptor)
            lines += said.removesuffix(_END).decode(errors="replace").splitlines()


def _listen(outlet: int, said: bytearray) -> None:
    """Take all that comes out of a pipe, up to ``_END``.

    A pipe, unlike a file, needs no directory and no room on a disk; somebody has to read it meanwhile, since
    it holds little. It may never end by itself: a program started meanwhile has its other end, too.
    """
    while not said.endswith(_END):
        said += os.read(outlet, _CHUNK)


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
