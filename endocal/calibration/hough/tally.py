"""The entropy of votes (Lee et al. 2013, eq. 5 and 6), from the numbers of the cells that they fall into."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..straightness import Floats
from .votes import Cells, Room

# Sums of such steps are exact, up to 2^53 of them: equal maps have equal entropies, in whatever order.
STEP = 2.0**-28


def gains_of(votes: int) -> Floats:
    """Return c ln c for c from 0 to ``votes``, in whole steps."""
    counts = np.arange(votes + 1)
    return np.rint(counts * np.log(np.maximum(counts, 1)) / STEP) * STEP


class Tally:
    """Votes that many models have in common, and the entropies that the others' make with them.

    ``gains`` are those of as many votes as there are in all, ``settled`` (k,) the cells of the common ones.
    """

    def __init__(self, gains: Floats, settled: Cells) -> None:
        self._gains = gains
        self._there: NDArray[np.int32] | None = None
        self._total = 0.0
        self._before = 0
        if len(settled):
            # The first and the last cell, which hold no vote, stand for all beyond.
            self._before = int(settled.min()) - 1
            last = int(settled.max()) - self._before + 1
            there = np.bincount(settled - self._before, minlength=last + 1)
            self._there = there.astype(np.int32)
            self._total = float(gains.take(self._there).sum())

    @property
    def entropy(self) -> float:
        """That of the common votes, where there are no others."""
        return float(self._entropies(np.array(self._total)))

    def entropies(self, cells: Cells, room: Room) -> Floats:
        """The entropy, (m,), of each row of the other votes' cells (m, n), which it sorts.

        Sorting brings the votes for one cell together; that is faster than counting in a map that is mostly
        empty.
        """
        m, n = cells.shape
        cells.sort(axis=1)
        flat = cells.ravel()
        first = room.flags(m * n + 1)
        np.not_equal(flat[1:], flat[:-1], out=first[1:-1])
        first[::n] = True
        starts = np.flatnonzero(first)
        votes = np.subtract(starts[1:], starts[:-1], out=room.counts(len(starts) - 1))
        gained = room.gains(len(votes))
        if self._there is None:
            self._gains.take(votes, out=gained, mode="clip")
        else:
            cell = flat.take(starts[:-1])
            cell -= self._before
            there = self._there.take(cell, mode="clip")
            votes += there
            self._gains.take(votes, out=gained, mode="clip")
            gained -= self._gains.take(there)
        rows = np.searchsorted(starts, np.arange(0, m * n, n))
        return self._entropies(np.add.reduceat(gained, rows) + self._total)

    def _entropies(self, sums: Floats) -> Floats:
        """From the sums of c ln c."""
        n = len(self._gains) - 1
        return np.asarray(np.log(n) - sums / n)
