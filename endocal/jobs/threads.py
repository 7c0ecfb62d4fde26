"""How many threads the libraries below may start."""

from __future__ import annotations

import os

# Each is read once, when its library is loaded: PoCL's devices and OpenCV's loops.
_SETTINGS = ("POCL_MAX_PTHREAD_COUNT", "OPENCV_FOR_THREADS_NUM")
# NumPy's linear algebra, which no job uses for much at once: its threads cost more than they gain.
_ALGEBRA = "OPENBLAS_NUM_THREADS"


def limit_threads(count: int) -> None:
    """Let the libraries of this process that are not loaded yet use ``count`` threads each; 0: all cores.

    Linear algebra uses one. What the environment says already stays. Decoders and encoders have their own
    limit in CorrectionSpec.
    """
    os.environ.setdefault(_ALGEBRA, "1")
    for name in _SETTINGS if count else ():
        os.environ.setdefault(name, str(count))
