"""The diameter over time: smooth when still, without lag in a zoom, deaf to a single false detection."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise


@dataclass(frozen=True)
class SmoothingSpec:
    """How the measured diameters of successive frames are taken together; all figures are relative.

    A zoom may change its speed by ``acceleration`` per frame and frame (one standard deviation), or by as
    much as it did of late: a measurement more than ``surprise`` standard deviations off tells of that, and
    ``forgetting`` of it is forgotten with each frame.

    A measurement further off than ``gate`` standard deviations, held within ``gates``, waits until the next
    ones agree with it, so that one false detection moves nothing; ``patience`` says how many must agree on a
    small jump and on one larger than ``large_jump``, each within ``max_speed`` of the one before. Up to
    ``fastest`` per frame, three agree if their speed is the same within half of ``max_speed``. ``floor`` is
    the least standard deviation of a measurement.
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
    floor: float = 3e-4


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
        self._waiting: list[float] = []
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
    def is_moving(self) -> bool:
        """Say whether the speed is told from none."""
        return abs(self._speed) > 3 * math.sqrt(self._p[2])

    def restart(self, diameter: float, sigma: float, speed_sigma: float = 0.0) -> None:
        """Begin anew, standing still, at a diameter, px, known to ``sigma`` (relative).

        ``speed_sigma`` is what may be expected of its speed, relative per frame.
        """
        self._log, self._speed = math.log(diameter), 0.0
        self._p = (sigma * sigma, 0.0, speed_sigma * speed_sigma)
        self._acceleration2 = self._spec.acceleration**2
        self._waiting.clear()

    def predict(self) -> None:
        """Go one frame on at the speed so far."""
        p00, p01, p11 = self._p
        self._acceleration2 = max(
            self._spec.acceleration**2, (1 - self._spec.forgetting) * self._acceleration2
        )
        q = self._acceleration2
        self._log += self._speed
        self._p = (p00 + 2 * p01 + p11 + q / 4, p01 + p11 + q / 2, p11 + q)

    def scale(self, logarithm: float, sigma: float) -> None:
        """Go one frame on by a relative scale that was measured between the two frames."""
        self._log += logarithm
        self._speed = logarithm
        p00 = self._p[0] + sigma * sigma
        self._p = (p00, 0.0, sigma * sigma + self._spec.acceleration**2)

    def stop(self) -> None:
        """Forget the speed: with nothing to see, a zoom is not taken to go on."""
        self._speed = 0.0
        self._p = (self._p[0], 0.0, self._p[2])

    def correct(self, diameter: float, sigma: float) -> bool:
        """Take in a measured diameter, px; False where it has to wait for others to agree with it."""
        spec = self._spec
        sigma = max(sigma, spec.floor, self._scatter)
        value = math.log(diameter)
        innovation = value - self._log
        p00, p01, p11 = self._p
        total = p00 + sigma * sigma
        # Amid a quick zoom what was a wild jump before is none.
        most = max(spec.gates[1], math.sqrt(self._acceleration2))
        gate = min(max(spec.gate * math.sqrt(total), spec.gates[0]), most)
        if abs(innovation) > gate:
            return self._wait(value, innovation, sigma)
        self._waiting.clear()
        # The scatter about a still estimate shows what the fit of a single circle cannot know of.
        self._scatter += 0.05 * (min(abs(innovation), 3 * sigma) * 0.8 - self._scatter)
        if innovation * innovation > spec.surprise**2 * total:
            self._accelerate(innovation * innovation - total)
        k0, k1 = p00 / total, p01 / total
        self._log += k0 * innovation
        self._speed += k1 * innovation
        self._p = ((1 - k0) * p00, (1 - k0) * p01, p11 - k1 * p01)
        return True

    def _wait(self, value: float, innovation: float, sigma: float) -> bool:
        spec = self._spec
        if self._waiting and abs(value - self._waiting[-1]) > spec.fastest:
            self._waiting.clear()
        self._waiting.append(value)
        needed = spec.patience[abs(innovation) > spec.large_jump]
        if not (self._agree(needed) or self._zoom_on()):
            return False
        change = (value - self._waiting[-2]) - self._speed
        self._accelerate((change / needed) ** 2)
        self._log, self._speed = value, value - self._waiting[-2]
        # The speed is the difference of two measurements, of which one is the value.
        variance = sigma * sigma
        self._p = (variance, variance, 2 * variance + self._acceleration2)
        self._waiting.clear()
        return True

    def _agree(self, needed: int) -> bool:
        """Say whether as many of the last that wait are near one another."""
        last = self._waiting[-needed:]
        near = all(abs(b - a) <= self._spec.max_speed for a, b in pairwise(last))
        return len(last) == needed and near

    def _zoom_on(self) -> bool:
        """Say whether the last three that wait are those of one quick zoom."""
        if len(self._waiting) < 3:
            return False
        a, b, c = self._waiting[-3:]
        return abs(c - 2 * b + a) <= self._spec.max_speed / 2

    def _accelerate(self, square: float) -> None:
        """Expect more of what the speed, by its ``square``, seems to have changed within this frame."""
        self._acceleration2 = max(self._acceleration2, square)
