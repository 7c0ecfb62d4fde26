"""What is to be expected of the hand that holds the camera: how quickly it comes nearer."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class HandSpec:
    """What is expected of hands; speeds are in distances to the scene per s, one standard deviation.

    A hand comes nearer by ``aside`` of how quickly it went aside within the last ``roaming`` s, and by
    ``least``. With the probability ``freely`` it does so by ``usual`` besides, in a ``hurry`` (another) by
    ``hurried``. Till it was seen for ``settle`` s it is taken to go aside as quickly as ``usual`` says.
    """

    usual: float = 0.07
    hurried: float = 0.3
    hurry: float = 0.03
    least: float = 0.01
    freely: float = 0.1
    settle: float = 0.3
    aside: float = 1.0
    roaming: float = 2.0


class Hand:
    """How quickly a hand comes nearer, by how quickly it goes aside."""

    def __init__(self, spec: HandSpec = HandSpec()) -> None:
        self._spec = spec
        # The square of the speed aside, in one direction, (distances per s)^2, summed over the s of late.
        self._roamed, self._late = 0.0, 0.0
        # Seconds in all that it was seen.
        self._seen = 0.0

    @property
    def speed(self) -> float:
        """How quickly it is expected to come nearer where it does not do so freely."""
        return self._nearer(self._spec.least)

    @property
    def aside(self) -> float:
        """How quickly it went aside of late, in one direction."""
        return math.sqrt(self._roamed / self._late) if self._late else 0.0

    @property
    def ways(self) -> tuple[tuple[float, float], ...]:
        """The speeds that may be expected of it, each with its probability."""
        spec = self._spec
        ways = (
            (spec.least, 1 - spec.hurry - spec.freely),
            (spec.usual, spec.freely),
            (spec.hurried, spec.hurry),
        )
        return tuple((self._nearer(speed), probability) for speed, probability in ways)

    def learn(self, aside: NDArray[np.float64], seconds: float) -> None:
        """Take in how quickly it goes aside, (2,) distances per s, after so many more ``seconds``."""
        roaming = self._spec.roaming
        kept = math.exp(-seconds / roaming)
        late = (1 - kept) * roaming
        self._roamed = kept * self._roamed + late * float(np.mean(np.square(aside)))
        self._late = kept * self._late + late
        self._seen += seconds

    def _nearer(self, speed: float) -> float:
        """Return how quickly it comes nearer, per s, if it does so at ``speed`` even where it stays."""
        spec = self._spec
        # What was expected at first fades with all that was seen, and not with that of late alone.
        settle = spec.settle * (self._late / self._seen if self._seen else 1.0)
        before = settle * (spec.usual / spec.aside) ** 2
        return math.hypot(
            speed, spec.aside * math.sqrt((self._roamed + before) / (self._late + settle))
        )
