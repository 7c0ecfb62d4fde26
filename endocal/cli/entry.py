"""Where the process begins: an interrupt is one quiet line from the first moment on, imports included."""

from __future__ import annotations

import contextlib
import os

_INTERRUPTED = 130


def main() -> None:
    """Run the process's own command line and exit."""
    try:
        from ..jobs.threads import limit_threads

        limit_threads(0)
        from .app import main as run

        run()
    except KeyboardInterrupt:
        # Half-imported modules cannot be trusted to end the process in order.
        with contextlib.suppress(OSError):
            os.write(2, b"endocal: interrupted\n")
        os._exit(_INTERRUPTED)
