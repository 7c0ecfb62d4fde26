"""Sound tracks that show whether picture and sound stay together."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

KINDS = ("sweep", "clicks", "none")
RATE = 48000
_LEVEL = 0.25


def sound_track(kind: str, duration: float) -> NDArray[np.float32] | None:
    """Return samples at ``RATE`` Hz, float32 (n,), -1 to 1; None for ``none``.

    ``sweep``: a tone that rises from 200 to 2000 Hz over ``duration`` s, evenly in pitch. ``clicks``: a
    short 1000 Hz tone at the start of each second.
    """
    if kind == "none":
        return None
    t = np.arange(round(duration * RATE)) / RATE
    if kind == "sweep":
        growth = np.log(10) / duration
        wave = np.sin(2 * np.pi * 200 * np.expm1(growth * t) / growth)
        wave *= np.clip(np.minimum(t, duration - t) / 0.02, 0, 1)
    else:
        within = t % 1.0
        wave = np.sin(2 * np.pi * 1000 * within) * np.exp(-within / 0.005)
    return (_LEVEL * wave).astype(np.float32)
