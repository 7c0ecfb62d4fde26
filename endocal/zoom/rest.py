"""Whether the zoom moves at all: a zoom ring rests most of the time, a hand never does.

What a zoom and what a moving camera made of the picture is told apart only as well as lens and scene allow.
So it is weighed, over a short time, whether a resting or a moving zoom explains the picture better, before
what is to be expected of zooms and hands; and what remains in doubt is stated.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .evidence import Late, Weighed, explain, mixed
from .hand import Hand, HandSpec
from .parallax import ScaleStep

# Per s; it only keeps finite what the picture does not tell.
_ANY_SPEED = 1.0


@dataclass(frozen=True)
class RestSpec:
    """What is expected of zooms and hands; it is weighed over ``window`` s.

    A moving zoom changes by ``zoom``, relative per s (one standard deviation, as all of these); where errors
    do not last, so that it can be told, with the probability ``slowly`` by ``slow``. A resting zoom moves
    with the probability ``starts``, one that moved with ``goes_on``. One whose speed was told keeps it,
    within ``steady`` of it, with the probability ``keeps``, of which 1/e is left after ``told`` s.

    Of a step's errors the part ``lasts`` at least is that of the next ones too. Some zoom passes for
    approach, or the reverse, by ``surely`` per s, as far as errors last by ``mistake``, and by ``bends`` of
    how quickly the hand goes aside times the scene's curvature, since the scene is never quite known. What
    seemed a zoom at rest is such a mistake, remembered, and forgotten, within ``memory`` s. In the long run
    ``confused`` of what the two made of the picture together may be the other's. Once a zoom is noticed,
    what it did in the last ``history`` s is made up for, and in the last ``ramp`` s as far back as it seemed
    to go that way, by more than ``likely`` standard deviations.
    """

    window: float = 0.32
    history: float = 0.48
    ramp: float = 3.5
    likely: float = 0.7
    zoom: float = 0.3
    slow: float = 0.06
    slowly: float = 0.5
    starts: float = 0.05
    goes_on: float = 0.6
    steady: float = 0.5
    keeps: float = 0.8
    told: float = 0.4
    lasts: float = 0.1
    surely: float = 0.002
    bends: float = 3.0
    mistake: float = 0.02
    memory: float = 0.5
    confused: float = 0.7
    hand: HandSpec = field(default_factory=HandSpec)


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

    ``seeming`` is the speed of zoom, per s, that it seemed at rest, known to ``deviation``; 0 once it has
    counted. ``lasting`` is the part of its errors that is that of the next steps, too.
    """

    def __init__(self, step: ScaleStep, seconds: float, lasts: float) -> None:
        self.seconds = seconds
        self.seeming = 0.0
        self.deviation = 0.0
        self.counted = False
        self.aside = step.aside
        self.lasting = max(step.lasting, lasts)
        self.curved = step.curved
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


class ZoomRest:
    """Lets the steps of a moving zoom through, those from before it was noticed included."""

    def __init__(self, spec: RestSpec = RestSpec()) -> None:
        self._spec = spec
        self._steps: deque[_Step] = deque()
        # Those that went before, the latest last.
        self._before: deque[_Step] = deque()
        self._moves = False
        self._mistaken = 0.0
        # The speed of zoom that was told, per s, and the probability that it is still the same.
        self._told, self._keeps = 0.0, 0.0
        self._hand = Hand(spec.hand)

    @property
    def rests(self) -> bool:
        """Say whether the zoom was at rest of late."""
        return not self._moves

    @property
    def hand(self) -> float:
        """How quickly the camera is expected to come nearer, in distances per s: one standard deviation."""
        return self._hand.speed

    def forget(self, speed: float | None = None) -> None:
        """Begin anew, at rest or with a zoom that moves already at a ``speed``, per s."""
        self._steps.clear()
        self._before.clear()
        self._moves = speed is not None
        self._mistaken = 0.0
        self._told, self._keeps = (0.0, 0.0) if not speed else (speed, self._spec.keeps)

    def take(self, step: ScaleStep, seconds: float) -> ZoomShare:
        """Return what of a step that took ``seconds`` s was zoom."""
        spec, steps = self._spec, self._steps
        steps.append(_Step(step, seconds, spec.lasts))
        while len(steps) > 1 and sum(s.seconds for s in steps) > spec.history:
            self._remember(steps.popleft())
        late = self._late()
        together = self._together(late)
        aside = np.sum([s.aside for s in late], axis=0) / sum(s.seconds for s in late)
        self._hand.learn(aside, seconds)
        weighed = self._weigh(together)
        most = max(w.evidence for w in weighed)
        weights = np.exp([w.evidence - most for w in weighed])
        weights /= weights.sum()
        moving = sum(p for p, w in zip(weights, weighed, strict=True) if w.moves)
        self._moves = bool(moving > 0.5)
        # A zoom that came to rest begins anew at any speed.
        self._keeps *= math.exp(-seconds / spec.told) if self._moves else 0.0
        best = max((w for w in weighed if w.moves == self._moves), key=lambda w: w.evidence)
        told = max((w for w in weighed if w.moves), key=lambda w: w.evidence)
        # How well many steps tell decides what it was; by how much, all may be wrong as each of them.
        off = [(w.zoom - best.zoom) ** 2 + together.steps * w.variance for w in weighed]
        doubt = math.sqrt(float(weights @ off))
        if not self._moves:
            confused = spec.confused * together.lasting * abs(told.zoom + told.hand)
            deviation = math.hypot(math.sqrt(told.variance), confused)
            steps[-1].seeming, steps[-1].deviation = told.zoom, deviation
            return ZoomShare(0.0, doubt, told.zoom * seconds, deviation)
        # What came before it was noticed is made up for.
        zoom, seemed = self._count(best.hand)
        ramp = self._ramp(best.zoom)
        return ZoomShare(zoom + ramp, doubt, -seemed - ramp, 0.0)

    def _count(self, hand: float) -> tuple[float, float]:
        """Return the zoom of the steps that have not counted yet, and what of it had seemed one till now.

        A zoom that turns or pauses looks at rest for a moment, and is noticed anew after it: the steps from
        before have counted by then. What counts was no mistake either, and is not remembered as one.
        """
        zoom = seemed = 0.0
        for step in self._steps:
            if not step.counted:
                # Errors that do not last are none of the next steps'.
                mistaken = step.lasting * self._mistaken
                zoom += step.zoom(hand) - step.seconds * mistaken
                seemed += step.seeming * step.seconds
                step.counted, step.seeming = True, 0.0
        return zoom, seemed

    def _ramp(self, speed: float) -> float:
        """Return the logarithm of what seemed a zoom before the history, and was that of this ``speed``.

        A zoom that sets in or turns gently is slow at first.
        """
        zoom = 0.0
        while self._before:
            step = self._before.pop()
            seemed = math.copysign(step.seeming, step.seeming * speed)
            if step.counted or seemed <= self._spec.likely * step.deviation:
                break
            # As far as errors last, this one may have lasted as well.
            zoom += (1 - step.lasting) * step.seeming * step.seconds
        self._before.clear()
        return zoom

    def _remember(self, step: _Step) -> None:
        """Take in what seemed a zoom and was none."""
        spec, before = self._spec, self._before
        before.append(step)
        while sum(s.seconds for s in before) > spec.ramp - spec.history:
            before.popleft()
        kept = math.exp(-step.seconds / spec.memory)
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

    def _together(self, late: Sequence[_Step]) -> Late:
        """Take steps together."""
        spec = self._spec
        lasting = float(np.mean([s.lasting for s in late]))
        # The scene's shape and what does not fit it hardly change from one frame to the next, so that many
        # frames tell no more than one, and their mean is steadier; noise is another in each.
        steps = len(late) / (1 + (len(late) - 1) * lasting)
        each = np.mean([s.information for s in late], axis=0)
        # A scene that bends does so in more ways than a quadratic's, which count as the hand moves.
        bends = spec.bends * float(np.mean([s.curved for s in late])) * self._hand.aside
        mistake = math.hypot(spec.surely, spec.mistake * lasting, bends)
        information = mixed(steps * each, mistake)
        target = information @ np.mean([s.speeds() for s in late], axis=0)
        return Late(information, target, steps, lasting)

    def _weigh(self, late: Late) -> list[Weighed]:
        """Weigh a resting and a moving zoom, each with a hand that sways, moves freely or hurries."""
        spec, information, target = self._spec, late.information, late.target
        moves = (1 - self._keeps) * (spec.goes_on if self._moves else spec.starts)
        rests = 1 - self._keeps - moves
        slowly = spec.slowly * (1 - late.lasting)
        zooms = [
            (0.0, spec.zoom, moves * (1 - slowly)),
            (0.0, spec.slow, moves * slowly),
            (self._told, spec.steady * abs(self._told), self._keeps),
        ]
        zooms = [zoom for zoom in zooms if zoom[2] > 0]
        out = []
        for hand, usual in self._hand.ways:
            _, rest = explain(information[1:, 1:], target[1:], np.array([hand]))
            out.append(Weighed(False, rest + math.log(usual * rests), 0.0, 0.0, 0.0))
            for mean, deviation, prior in zooms:
                usually, expected = np.array([mean, 0.0]), np.array([deviation, hand])
                surplus = target - information @ usually
                (found, covariance), zoom = explain(information, surplus, expected)
                zoom += float(usually @ (target + surplus)) / 2
                out.append(
                    Weighed(
                        True,
                        zoom + math.log(usual * prior),
                        mean + float(found[0]),
                        float(found[1]),
                        float(covariance[0, 0]),
                    )
                )
        return out
