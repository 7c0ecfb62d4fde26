"""How many threads the libraries below may start."""

from __future__ import annotations

import os

# Each is read once, when its library is loaded: PoCL's devices, OpenCV's loops, NumPy's linear algebra.
_SETTINGS = ("POCL_MAX_PTHREAD_COUNT", "OPENCV_FOR_THREADS_NUM", "OPENBLAS_NUM_THREADS")


def limit_threads(count: int) -> None:
    """Let the libraries of this process that are not loaded yet use ``count`` threads each; 0: all cores.

    What the environment says already stays. Decoders and encoders have their own limit in CorrectionSpec.
    """
    for name in _SETTINGS if count else ():
        os.environ.setdefault(name, str(count))
