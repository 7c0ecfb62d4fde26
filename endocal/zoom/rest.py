"""Whether the zoom moves at all: a zoom ring rests most of the time, a hand never does.

What a zoom and what a moving camera made of the picture is told apart only as well as lens and scene allow.
So it is weighed, over a short time, whether a resting or a moving zoom explains the picture better, before
what is to be expected of zooms and hands; and what remains in doubt is stated.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .parallax import ScaleStep

# Per s; it only keeps finite what the picture does not tell.
_ANY_SPEED = 1.0


@dataclass(frozen=True)
class RestSpec:
    """What is expected of zooms and hands; it is weighed over ``window`` s.

    A moving zoom changes by ``zoom``, relative per s (one standard deviation, as all of these). A hand comes
    nearer by ``aside`` of how quickly it went aside within the last ``roaming`` s, and by ``least``. With the
    probability ``freely`` it does so by ``hand`` besides, in a ``hurry`` (another) by ``hurried``. Till it
    was seen for ``settle`` s it is taken to go aside as quickly as ``hand`` says. A resting zoom moves with
    the probability ``starts``, one that moved with ``goes_on``. One whose speed was told keeps it, within
    ``steady`` of it (one standard deviation), with the probability ``keeps``, of which 1/e is left after
    ``told`` s.
    Some zoom passes for approach, or the reverse, by ``mistake`` per s (one standard deviation) since the
    scene is never quite known; what seemed a zoom at rest is such a mistake, remembered, and forgotten,
    within ``memory`` s. In the long run ``confused`` of what the two made of the picture together (one
    standard deviation) may be the other's. Once a zoom is noticed, what it did in the last ``history`` s is
    made up for.
    """

    window: float = 0.32
    history: float = 0.48
    zoom: float = 0.3
    hand: float = 0.07
    hurried: float = 0.3
    hurry: float = 0.03
    least: float = 0.01
    freely: float = 0.2
    settle: float = 0.3
    aside: float = 1.0
    roaming: float = 2.0
    starts: float = 0.05
    goes_on: float = 0.6
    steady: float = 0.5
    keeps: float = 0.8
    told: float = 0.4
    mistake: float = 0.02
    memory: float = 0.5
    confused: float = 0.7


class ZoomShare(NamedTuple):
    """What of a step counts as zoom: a ``logarithm``, and the ``doubt`` of the zoom's speed, per s.

    ``seeming`` is the logarithm that does not count since the zoom is taken to rest, and ``seeming_doubt``
    one standard deviation of its speed, per s. What seemed so and counts after all is taken back there.
    """

    logarithm: float
    doubt: float
    seeming: float
    seeming_doubt: float


class _Step:
    """One step: what the picture says, over how many seconds, and whether it has ``counted`` as zoom.

    ``seeming`` is the speed of zoom, per s, that it seemed at rest; 0 once it has counted.
    """

    def __init__(self, step: ScaleStep, seconds: float) -> None:
        self.seconds = seconds
        self.seeming = 0.0
        self.counted = False
        self.aside = step.aside
        self.information = step.information * seconds**2
        self._target = step.target * seconds

    def speeds(self) -> NDArray[np.float64]:
        """Return zoom and approach as the picture alone has them, per s; near 0 where it tells nothing."""
        information = self.information + np.eye(2) / _ANY_SPEED**2
        return np.asarray(np.linalg.solve(information, self._target))

    def zoom(self, hand: float) -> float:
        """Return the logarithm of the zoom, given how fast the camera comes nearer."""
        known = self.information[0, 0] + _ANY_SPEED**-2
        return float((self._target[0] - self.information[0, 1] * hand) / known) * self.seconds


class _Weighed(NamedTuple):
    """A hypothesis: whether the zoom moves, its evidence, and what it says of zoom and hand."""

    moves: bool
    evidence: float
    zoom: float
    hand: float
    variance: float


class ZoomRest:
    """Lets the steps of a moving zoom through, those from before it was noticed included."""

    def __init__(self, spec: RestSpec = RestSpec()) -> None:
        self._spec = spec
        self._steps: deque[_Step] = deque()
        self._moves = False
        self._mistaken = 0.0
        # The speed of zoom that was told, per s, and the probability that it is still the same.
        self._told, self._keeps = 0.0, 0.0
        # The square of the speed aside, in one direction, (distances per s)^2, summed over the s of late.
        self._roamed, self._watched = 0.0, 0.0

    @property
    def rests(self) -> bool:
        """Say whether the zoom was at rest of late."""
        return not self._moves

    @property
    def hand(self) -> float:
        """How quickly the camera is expected to come nearer, in distances per s: one standard deviation."""
        return self._nearer(self._spec.least)

    def forget(self, speed: float | None = None) -> None:
        """Begin anew, at rest or with a zoom that moves already at a ``speed``, per s."""
        self._steps.clear()
        self._moves = speed is not None
        self._mistaken = 0.0
        self._told, self._keeps = (0.0, 0.0) if not speed else (speed, self._spec.keeps)

    def take(self, step: ScaleStep, seconds: float) -> ZoomShare:
        """Return what of a step that took ``seconds`` s was zoom."""
        spec, steps = self._spec, self._steps
        steps.append(_Step(step, seconds))
        while len(steps) > 1 and sum(s.seconds for s in steps) > spec.history:
            self._remember(steps.popleft())
        late = self._late()
        self._learn_roaming(late, seconds)
        weighed = self._weigh(late)
        most = max(w.evidence for w in weighed)
        weights = np.exp([w.evidence - most for w in weighed])
        weights /= weights.sum()
        moving = sum(p for p, w in zip(weights, weighed, strict=True) if w.moves)
        self._moves = bool(moving > 0.5)
        # A zoom that came to rest begins anew at any speed.
        self._keeps *= math.exp(-seconds / spec.told) if self._moves else 0.0
        best = max((w for w in weighed if w.moves == self._moves), key=lambda w: w.evidence)
        told = max((w for w in weighed if w.moves), key=lambda w: w.evidence)
        off = [(w.zoom - best.zoom) ** 2 + w.variance for w in weighed]
        doubt = math.sqrt(float(weights @ off))
        if not self._moves:
            steps[-1].seeming = told.zoom
            confused = spec.confused * abs(told.zoom + told.hand)
            deviation = math.hypot(math.sqrt(told.variance), confused)
            return ZoomShare(0.0, doubt, told.zoom * seconds, deviation)
        # What came before it was noticed is made up for.
        zoom, seemed = self._count(best.hand)
        return ZoomShare(zoom, doubt, -seemed, 0.0)

    def _count(self, hand: float) -> tuple[float, float]:
        """Return the zoom of the steps that have not counted yet, and what of it had seemed one till now.

        A zoom that turns or pauses looks at rest for a moment, and is noticed anew after it: the steps from
        before have counted by then. What counts was no mistake either, and is not remembered as one.
        """
        zoom = seemed = 0.0
        for step in self._steps:
            if not step.counted:
                zoom += step.zoom(hand) - step.seconds * self._mistaken
                seemed += step.seeming * step.seconds
                step.counted, step.seeming = True, 0.0
        return zoom, seemed

    def _remember(self, step: _Step) -> None:
        """Take in what seemed a zoom and was none."""
        kept = math.exp(-step.seconds / self._spec.memory)
        self._mistaken = kept * self._mistaken + (1 - kept) * step.seeming

    def _late(self) -> list[_Step]:
        """Return the steps of the last ``window`` s, the latest first."""
        late: list[_Step] = []
        seconds = 0.0
        for step in reversed(self._steps):
            seconds += step.seconds
            if late and seconds > self._spec.window:
                break
            late.append(step)
        return late

    def _learn_roaming(self, late: Sequence[_Step], seconds: float) -> None:
        """Take in how quickly the camera went aside of late; the mean over several steps is steadier."""
        speed = sum(s.aside for s in late) / sum(s.seconds for s in late)
        spec = self._spec
        kept = math.exp(-seconds / spec.roaming)
        watched = (1 - kept) * spec.roaming
        self._roamed = kept * self._roamed + watched * float(np.mean(np.square(speed)))
        self._watched = kept * self._watched + watched

    def _nearer(self, speed: float) -> float:
        """Return how quickly a hand comes nearer, per s, that does so at ``speed`` even where it stays."""
        spec = self._spec
        before = spec.settle * (spec.hand / spec.aside) ** 2
        roaming = (self._roamed + before) / (self._watched + spec.settle)
        return math.hypot(speed, spec.aside * math.sqrt(roaming))

    def _weigh(self, late: Sequence[_Step]) -> list[_Weighed]:
        """Weigh a resting and a moving zoom, each with a hand that sways, moves freely or hurries."""
        spec = self._spec
        # The scene's shape and what does not fit it hardly change from one frame to the next, so that many
        # frames tell no more than one; their mean is steadier.
        information = _mixed(np.mean([s.information for s in late], axis=0), spec.mistake)
        target = information @ np.mean([s.speeds() for s in late], axis=0)
        moves = (1 - self._keeps) * (spec.goes_on if self._moves else spec.starts)
        rests = 1 - self._keeps - moves
        zooms = [(0.0, spec.zoom, moves)]
        if self._keeps > 0:
            zooms.append((self._told, spec.steady * abs(self._told), self._keeps))
        hands = (
            (spec.least, 1 - spec.hurry - spec.freely),
            (spec.hand, spec.freely),
            (spec.hurried, spec.hurry),
        )
        out = []
        for speed, usual in hands:
            hand = self._nearer(speed)
            _, rest = _explain(information[1:, 1:], target[1:], np.array([hand]))
            out.append(_Weighed(False, rest + math.log(usual * rests), 0.0, 0.0, 0.0))
            for mean, deviation, prior in zooms:
                usually, expected = np.array([mean, 0.0]), np.array([deviation, hand])
                surplus = target - information @ usually
                (found, covariance), zoom = _explain(information, surplus, expected)
                zoom += float(usually @ (target + surplus)) / 2
                out.append(
                    _Weighed(
                        True,
                        zoom + math.log(usual * prior),
                        mean + float(found[0]),
                        float(found[1]),
                        float(covariance[0, 0]),
                    )
                )
        return out


def _explain(
    information: NDArray[np.float64], target: NDArray[np.float64], expected: NDArray[np.float64]
) -> tuple[tuple[NDArray[np.float64], NDArray[np.float64]], float]:
    """Return the posterior mean and covariance before ``expected`` deviations, and the log evidence."""
    covariance = np.asarray(np.linalg.inv(information + np.diag(expected**-2.0)), np.float64)
    found = covariance @ target
    shrunk = float(np.linalg.slogdet(covariance)[1]) - 2 * float(np.log(expected).sum())
    return (found, covariance), (shrunk + float(target @ found)) / 2


def _mixed(information: NDArray[np.float64], mistake: float) -> NDArray[np.float64]:
    """Add to what is known that zoom may pass for approach, and the reverse, by a ``mistake`` per s."""
    along = information @ np.array([1.0, -1.0])
    loss = np.outer(along, along) / (mistake**-2.0 + along[0] - along[1])
    return np.asarray(information - loss)
