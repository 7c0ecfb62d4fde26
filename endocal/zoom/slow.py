"""Slow zooms: what no third of a second tells, but what adds up over many.

While the zoom is taken to rest, the picture still says of every step how much of it seems a zoom. That is
mistaken by as much as lens and scene allow; but a hand that sways comes back, and its mistakes with it,
while a zoom that goes on in one direction adds up. So the sum is weighed: mistakes alone against mistakes
and a slow zoom.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from .doubt import GrowingDoubt


@dataclass(frozen=True)
class SlowSpec:
    """What is expected of slow zooms.

    There is one with the probability ``prior``: over many seconds neither is preferred. It is believed where
    it is more probable than ``doubtful`` in the end; up to there it counts as doubt alone. It changes by
    ``speed`` (relative per s, one standard deviation), and by ``most`` (relative) in all. A mistaken speed
    lasts for ``memory`` s; what it adds up to is taken back within ``back`` s, since a hand comes back.
    """

    prior: float = 0.5
    doubtful: float = 0.85
    speed: float = 0.05
    most: float = 0.5
    memory: float = 0.7
    back: float = 3.0


class SlowZoom:
    """What of the seeming zoom of steps at rest was one, so far as their sum tells."""

    def __init__(self, spec: SlowSpec = SlowSpec()) -> None:
        self._spec = spec
        self._mistake = GrowingDoubt(spec.memory)
        self.restart()

    def restart(self) -> None:
        """Begin anew with nothing added up."""
        self._mistake.restart()
        self._sum = 0.0
        self._variance = 0.0
        self._seconds = 0.0
        # The probability of a slow zoom, and its mean and variance if there is one.
        self._weight, self._mean, self._spread = 0.0, 0.0, 0.0

    @property
    def logarithm(self) -> float:
        """The slow zoom so far, as a logarithm; 0 as long as it is not the clearly better explanation.

        From there on it is believed by and by, in full where it is sure, so that nothing jumps.
        """
        doubtful = self._spec.doubtful
        return max(0.0, self._weight - doubtful) / (1 - doubtful) * self._mean

    @property
    def sigma(self) -> float:
        """One standard deviation of ``logarithm``."""
        zoom, told = self._weight, self.logarithm
        return math.sqrt(zoom * ((self._mean - told) ** 2 + self._spread) + (1 - zoom) * told**2)

    def take(self, seeming: float, deviation: float, seconds: float) -> None:
        """Add a step of ``seconds`` s that seemed a zoom by a logarithm, its speed known to ``deviation``."""
        spec = self._spec
        self._sum += seeming
        self._seconds += seconds
        # A difference of two deviations of the hand: it falls off twice as fast as they.
        self._variance *= math.exp(-2 * seconds / spec.back)
        self._variance += self._mistake.grow(deviation, seconds)
        self._weigh()

    def _weigh(self) -> None:
        spec, mistake = self._spec, self._variance
        zoom = min(spec.speed * self._seconds, spec.most) ** 2
        both = mistake + zoom
        if mistake <= 0 or zoom <= 0:
            return
        evidence = (math.log(mistake / both) + self._sum**2 * (1 / mistake - 1 / both)) / 2
        odds = math.log(spec.prior / (1 - spec.prior)) + evidence
        self._weight = 1 / (1 + math.exp(-max(min(odds, 30.0), -30.0)))
        self._mean = self._sum * zoom / both
        self._spread = zoom * mistake / both
