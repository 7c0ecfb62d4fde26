"""How the doubt of an estimate grows whose speed is in doubt."""

from __future__ import annotations

import math


class GrowingDoubt:
    """The variance of what a speed adds up to that is off by an unknown, slowly changing amount.

    The error of the speed keeps its sign for about ``memory`` s: over less than that the doubt grows with
    time, over more with its root.
    """

    def __init__(self, memory: float) -> None:
        self._memory = memory
        # The covariance of what has added up with the speed's error, in units of the latter's deviation.
        self._shared = 0.0

    def restart(self) -> None:
        """Begin anew, with nothing added up yet."""
        self._shared = 0.0

    def grow(self, deviation: float, seconds: float) -> float:
        """Return by how much the variance grows in ``seconds`` s, at a speed known to ``deviation`` per s."""
        kept = math.exp(-seconds / self._memory)
        # A speed off by one deviation now adds up to so much: time, as long as that is short.
        reach = deviation * self._memory * (1 - kept)
        own = doubt_after(deviation, self._memory, seconds) ** 2
        growth = 2 * self._shared * reach + own
        self._shared = kept * self._shared + reach
        return growth


def doubt_after(deviation: float, memory: float, seconds: float) -> float:
    """Return the standard deviation that ``GrowingDoubt`` comes to after ``seconds`` s."""
    faded = 1 - math.exp(-seconds / memory)
    return deviation * math.sqrt(max(0.0, 2 * memory * (seconds - memory * faded)))
