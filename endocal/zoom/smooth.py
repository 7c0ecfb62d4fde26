"""The diameter over time: smooth when still, without lag in a zoom, deaf to a single false detection."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

from .clock import Elapsed

# So many that wait decide; what waited before them no longer counts.
_MOST_WAITING = 3


@dataclass(frozen=True)
class SmoothingSpec:
    """How the measured diameters of successive frames are taken together; all figures are relative.

    A zoom may change its speed by ``acceleration`` per frame and frame (one standard deviation), or by as
    much as it did of late: a measurement more than ``surprise`` standard deviations off tells of that, and
    ``forgetting`` of it is forgotten with each frame.

    A measurement further off than ``gate`` standard deviations, held within ``gates``, waits until the next
    ones agree with it, so that false detections move nothing; ``patience`` says how many must agree on a
    small jump and on one larger than ``large_jump``. Those that agree lie on the same side of the estimate,
    each as far off as the one before or further: by up to twice as much as that is off, as at the onset of a
    zoom, within ``max_speed``. What counts as nearer is a ``gate``, the least of two and the most of three.
    Up to ``fastest`` per frame, three agree if their speed is the same within half of ``max_speed``.
    What waited for longer than ``lasts`` s and ``lasts_frames`` is forgotten. ``floor`` is the least standard
    deviation of a measurement. A speed is taken to go on for ``reach`` frames at most while none arrives.
    """

    acceleration: float = 2e-4
    forgetting: float = 0.3
    surprise: float = 2.5
    gate: float = 4.5
    gates: tuple[float, float] = (3e-3, 1.5e-2)
    patience: tuple[int, int] = (2, 3)
    large_jump: float = 0.08
    max_speed: float = 0.06
    fastest: float = 0.15
    lasts: float = 1.0
    lasts_frames: float = 4.0
    floor: float = 3e-4
    reach: float = 10.0


class _Waiting(NamedTuple):
    """What waits: a logarithm, how far off the estimate it was, and how many frames after the last.

    ``waited`` is how many frames have waited by then, those that no longer count included.
    """

    value: float
    off: float
    frames: float
    waited: float


class DiameterFilter:
    """A Kalman filter of the logarithm of the diameter and of its speed per frame.

    A constant speed is followed without lag. Before the first measurement ``known`` is False.
    """

    def __init__(self, spec: SmoothingSpec = SmoothingSpec()) -> None:
        self._spec = spec
        self._log = math.nan
        self._speed = 0.0
        # Covariance of (logarithm, speed): p00, p01, p11.
        self._p = (0.0, 0.0, 0.0)
        # What was taken from the variance of the logarithm beyond what it was.
        self._owed = 0.0
        self._waiting: deque[_Waiting] = deque(maxlen=_MOST_WAITING)
        # Whether the last frame's measurement waits.
        self._waits = False
        # What went by since the last measurement, taken in or waiting.
        self._since = Elapsed(0.0, 0.0)
        # Which way the last jump went, until the next measurement says whether it was a zoom.
        self._jumped = 0.0
        self._scatter = spec.floor
        self._acceleration2 = spec.acceleration**2

    @property
    def known(self) -> bool:
        """Say whether there is an estimate yet."""
        return not math.isnan(self._log)

    @property
    def diameter(self) -> float:
        """The estimate, in px."""
        return math.exp(self._log)

    @property
    def sigma(self) -> float:
        """One standard deviation of the estimate, relative."""
        return math.sqrt(self._p[0])

    @property
    def owed(self) -> float:
        """What ``pull`` took beyond this variance: it is to be taken from what the caller counts besides."""
        return self._owed

    @property
    def pending(self) -> float:
        """How far off the estimate is, relative, if what waits is right: at most what a zoom can reach."""
        if not (self._waits and self._waiting):
            return 0.0
        reached = self._spec.max_speed * self._waiting[-1].waited
        return min(abs(self._waiting[-1].off), reached)

    @property
    def speed(self) -> float:
        """The relative speed per frame."""
        return self._speed

    @property
    def is_moving(self) -> bool:
        """Say whether the speed is told from none."""
        return abs(self._speed) > 3 * math.sqrt(self._p[2])

    def restart(self, diameter: float, sigma: float, speed_sigma: float = 0.0) -> None:
        """Begin anew, standing still, at a diameter, px, known to ``sigma`` (relative).

        ``speed_sigma`` is what may be expected of its speed, relative per frame.
        """
        self._log, self._speed = math.log(diameter), 0.0
        self._p = (sigma * sigma, 0.0, speed_sigma * speed_sigma)
        self._owed = 0.0
        self._acceleration2 = self._spec.acceleration**2
        self._waiting.clear()
        self._jumped = 0.0

    def predict(self, elapsed: Elapsed = Elapsed()) -> None:
        """Go on by what went by since the last frame, at the speed so far."""
        frames = elapsed.frames
        self._pass(elapsed)
        unknown = 0.0
        if frames > self._spec.reach:
            unknown = self._speed * self._spec.reach
            self.stop()
        p00, p01, p11 = self._p
        self._acceleration2 = max(
            self._spec.acceleration**2,
            (1 - self._spec.forgetting) ** frames * self._acceleration2,
        )
        q = self._acceleration2
        self._log += self._speed * frames
        self._p = (
            unknown**2 + p00 + 2 * p01 * frames + p11 * frames**2 + q * frames**3 / 3,
            p01 + p11 * frames + q * frames**2 / 2,
            p11 + q * frames,
        )

    def scale(self, logarithm: float, sigma: float, elapsed: Elapsed = Elapsed()) -> None:
        """Go on to the next frame by a relative scale that was measured between the two."""
        self._pass(elapsed)
        self._log += logarithm
        self._speed = logarithm / elapsed.frames
        p00 = self._p[0] + sigma * sigma
        self._p = (p00, 0.0, (sigma / elapsed.frames) ** 2 + self._spec.acceleration**2)

    def pull(self, logarithm: float, variance: float) -> None:
        """Move the estimate by what became known of this frame, which takes a ``variance`` from its own.

        What that lacks is ``owed``, so that a later pull gives back no more than was taken.
        """
        self._log += logarithm
        left = self._p[0] - self._owed - variance
        self._p = (max(left, 0.0), *self._p[1:])
        self._owed = max(-left, 0.0)

    def recount(self, ratio: float) -> None:
        """Count from now on in frames that are ``ratio`` times as long as before."""
        self._speed *= ratio
        self._p = (self._p[0], self._p[1] * ratio, self._p[2] * ratio**2)

    def widen(self, sigma: float) -> None:
        """Let the estimate be less certain by ``sigma``, relative: something may have happened unseen."""
        self._p = (self._p[0] + sigma * sigma, *self._p[1:])

    def is_pause(self, elapsed: Elapsed) -> bool:
        """Say whether so much went by that nothing from before counts against a measurement."""
        return elapsed.seconds > self._spec.lasts and elapsed.frames > self._spec.lasts_frames

    def stop(self) -> None:
        """Forget the speed: with nothing to see, a zoom is not taken to go on."""
        self._speed = 0.0
        self._p = (self._p[0], 0.0, self._p[2])

    def _pass(self, elapsed: Elapsed) -> None:
        """Let what waits grow old."""
        frames, seconds = (a + b for a, b in zip(self._since, elapsed, strict=True))
        self._since = Elapsed(frames, seconds)
        self._waits = False
        if self.is_pause(self._since):
            self._waiting.clear()

    def correct(self, diameter: float, sigma: float) -> bool:
        """Take in a measured diameter, px; False where it has to wait for others to agree with it."""
        spec = self._spec
        sigma = max(sigma, spec.floor, self._scatter)
        value = math.log(diameter)
        innovation = value - self._log
        p00, p01, p11 = self._p
        total = p00 + sigma * sigma
        # Amid a quick zoom, or after a jump, what was a wild jump before is none.
        most = max(spec.gates[1], math.sqrt(self._acceleration2), math.sqrt(p11))
        gate = min(max(spec.gate * math.sqrt(total), spec.gates[0]), most)
        if abs(innovation) > gate:
            return self._wait(value, innovation, sigma)
        self._waiting.clear()
        self._owed = 0.0
        self._since = Elapsed(0.0, 0.0)
        # The scatter about a still estimate shows what the fit of a single circle cannot know of.
        self._scatter += 0.05 * (min(abs(innovation), 3 * sigma) * 0.8 - self._scatter)
        if innovation * innovation > spec.surprise**2 * total:
            self._accelerate(innovation * innovation - total)
        k0, k1 = p00 / total, p01 / total
        self._log += k0 * innovation
        self._speed += k1 * innovation
        self._p = ((1 - k0) * p00, (1 - k0) * p01, p11 - k1 * p01)
        if self._speed * self._jumped < 0:
            # To go back is no zoom.
            self._speed = 0.0
            self._p = (self._p[0], 0.0, self._acceleration2)
        self._jumped = 0.0
        return True

    def _wait(self, value: float, innovation: float, sigma: float) -> bool:
        spec = self._spec
        since, self._since = self._since, Elapsed(0.0, 0.0)
        frames = max(since.frames, 1.0)
        if self._waiting and abs(value - self._waiting[-1].value) > spec.fastest * frames:
            self._waiting.clear()
        self._waits = True
        waited = frames + (self._waiting[-1].waited if self._waiting else 0.0)
        self._waiting.append(_Waiting(value, innovation, frames, waited))
        needed = spec.patience[abs(innovation) > spec.large_jump]
        if not (
            any(self._agree(n, sigma) for n in range(needed, _MOST_WAITING + 1)) or self._zoom_on()
        ):
            return False
        apart = (value - self._waiting[-2].value) / frames
        self._accelerate(((apart - self._speed) / needed) ** 2)
        # Between a zoom at this speed and a jump that is over the next measurement decides: till then the
        # estimate stays where the last one was.
        self._log, self._speed = value, 0.0
        variance = sigma * sigma
        self._waits = False
        self._owed = 0.0
        self._jumped = innovation
        self._p = (variance, 0.0, (2 * apart) ** 2 + 2 * variance + self._acceleration2)
        self._waiting.clear()
        return True

    def _agree(self, needed: int, sigma: float) -> bool:
        """Say whether as many of the last that wait tell of the same jump, or of a zoom that sets in."""
        spec, last = self._spec, list(self._waiting)[-needed:]
        if len(last) < needed or not _on_one_side(last):
            return False
        noise = max(spec.gate * math.sqrt(2) * sigma, spec.gates[needed > 2])
        return all(
            abs(b.value - a.value) <= spec.max_speed * b.frames
            and -noise <= abs(b.off) - abs(a.off) <= 2 * abs(a.off) * b.frames + noise
            for a, b in pairwise(last)
        )

    def _zoom_on(self) -> bool:
        """Say whether the last three that wait are those of one quick zoom."""
        last = list(self._waiting)
        if len(last) < _MOST_WAITING or not _on_one_side(last):
            return False
        before, after = ((b.value - a.value) / b.frames for a, b in pairwise(last))
        return abs(after - before) <= self._spec.max_speed / 2

    def _accelerate(self, square: float) -> None:
        """Expect more of what the speed, by its ``square``, seems to have changed within this frame."""
        self._acceleration2 = max(self._acceleration2, square)


def _on_one_side(waiting: Sequence[_Waiting]) -> bool:
    """Say whether all are off to the same side."""
    return all((w.off > 0) == (waiting[0].off > 0) for w in waiting)
