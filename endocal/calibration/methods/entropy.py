"""Entropy of vote maps (Lee et al. 2013, eq. 5 and 6)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def entropy(votes: NDArray[np.number], alone: float = 0.0) -> float:
    """Return the entropy, in nats, of a map of votes, of any shape; 0 for an empty one.

    ``alone`` more votes fell outside the map: each counts as one in a cell of its own, so that a model
    gains nothing by throwing points out of the map.
    """
    held = votes[votes > 0].astype(np.float64)
    total = float(held.sum()) + alone
    if total == 0:
        return 0.0
    p = held / total
    return float(alone / total * np.log(total) - (p * np.log(p)).sum())
