"""MTF50 of a slanted edge whose place is known (after ISO 12233)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.signal.windows import tukey

Floats = NDArray[np.float64]

# The edge profile: bins per px, how far to either side, px.
BINS, REACH = 4, 10.0


def mtf50(levels: Floats, distances: Floats) -> float:
    """Return the frequency, in cycles per px, at which the contrast of an edge has fallen to half.

    ``levels`` (n,) are grey levels of pixels at ``distances`` (n,) px from the edge, with sign. NaN where there
    are too few, or no edge.
    """
    near = np.abs(distances) < REACH
    index = np.floor((distances[near] + REACH) * BINS).astype(int)
    bins = int(2 * REACH * BINS)
    count = np.bincount(index, minlength=bins)[:bins]
    if np.any(count[2:-2] == 0):
        return float("nan")
    profile = np.bincount(index, levels[near], bins)[:bins] / np.maximum(count, 1)
    spread = np.diff(profile[2:-2])
    spread = spread * tukey(len(spread), 0.4)
    contrast = np.abs(np.fft.rfft(spread, 8 * len(spread)))
    if contrast[0] == 0:
        return float("nan")
    contrast /= contrast[0]
    # The derivative between neighbouring bins is itself a little filter.
    frequency = np.fft.rfftfreq(8 * len(spread), 1 / BINS)
    contrast /= np.maximum(np.sinc(frequency / BINS), 0.1)
    below = np.flatnonzero(contrast < 0.5)
    if len(below) == 0 or below[0] == 0:
        return float("nan")
    i = below[0]
    step = (contrast[i - 1] - 0.5) / (contrast[i - 1] - contrast[i])
    return float(frequency[i - 1] + step * (frequency[i] - frequency[i - 1]))
