"""What the multimedia library says: nothing on the terminal, and to us only where we listen.

Its messages come from any thread at any time, through one function for the whole process. PyAV's own, which
takes Python's lock, is installed only for the moments in which somebody listens: a thread of a decoder that
waits for that lock while its decoder is closed would wait for ever. Between them the library's own stands
there, told to be quiet. PyAV's level is never taken back to None, which a message that is under way then
would fail on.
"""

from __future__ import annotations

import contextlib
import logging
import threading
from collections.abc import Iterator

import av.logging

# AV_LOG_QUIET
_QUIET = -8
_listening = threading.Lock()
# The level of a program that listens itself and uses this package as a library.
_level_of_host = av.logging.get_level()

# What other threads say in such a moment has somewhere to go that is not the terminal.
logging.getLogger("libav").addHandler(logging.NullHandler())
av.logging.set_skip_repeated(False)


@contextlib.contextmanager
def heard(level: int, in_detail: bool = False) -> Iterator[list[tuple[int, str, str]]]:
    """Collect what the library says in this thread, down to ``level`` of av.logging, while the context lasts.

    Yields a list of (level, name, message). ``in_detail`` lets the library put in more where it describes
    something.
    """
    with _listening, av.logging.Capture() as messages:
        try:
            av.logging.set_level(level)
            if in_detail:
                av.logging.set_libav_level(av.logging.VERBOSE)
            yield messages
        finally:
            _fall_silent()


def _fall_silent() -> None:
    if _level_of_host is None:
        av.logging.set_libav_level(_QUIET)
        av.logging.restore_default_callback()
    else:
        av.logging.set_libav_level(av.logging.INFO)
        av.logging.set_level(_level_of_host)


_fall_silent()
