"""How far the visible circle lies from where the table has it: a scope has play in its coupler.

What bends the picture, and the stop that bounds it, are in the scope. So when the scope moves before the
sensor, the circle and the distortion centre move together, by the same pixels.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from ..boundary.detect import Located
from ..model import DivisionModel

Offset = tuple[float, float]


@dataclass(frozen=True)
class ShiftSpec:
    """How the shift of the circle is followed; lengths are in parts of the diameter.

    It may ``wander`` so far in a frame (one standard deviation), and within ``play`` in all; or as far as it
    did of late: a measurement more than ``surprise`` standard deviations off tells of that, and
    ``forgetting`` of it is forgotten with each frame. ``floor`` is the least standard deviation of a measured
    centre. A measurement further off than ``gate`` standard deviations waits until ``patience`` in a row are
    less than ``fastest`` per frame apart, so that one false circle moves nothing. What comes out stands still
    until the estimate has left it by two of its standard deviations, within ``still``.
    """

    wander: float = 1e-4
    play: float = 0.02
    surprise: float = 2.5
    forgetting: float = 0.3
    floor: float = 1e-4
    gate: float = 5.0
    patience: int = 3
    fastest: float = 5e-3
    still: tuple[float, float] = (2e-4, 1e-3)


class CircleShift:
    """The shift over the frames of a video.

    ``place`` gives the centre (x, y) px that a circle of a diameter (px) had when the lens was calibrated;
    None where nobody knows, and then there is no shift.
    """

    def __init__(
        self,
        place: Callable[[float], Offset | None],
        pixel_aspect: float = 1.0,
        spec: ShiftSpec = ShiftSpec(),
    ) -> None:
        self._place = place
        self._aspect = pixel_aspect
        self._spec = spec
        self._estimate: Offset | None = None
        self._variance = 0.0
        # How far it wandered of late in a frame, squared, in parts of the diameter.
        self._wander2 = spec.wander**2
        self._shown: Offset = (0.0, 0.0)
        self._waiting: list[Offset] = []
        # Frames since the last measurement.
        self._frames = 0.0

    @property
    def value(self) -> Offset:
        """The shift (x, y), px of the frame, that holds now."""
        return self._shown

    def advance(self, frames: float) -> None:
        """Go on by so many frames."""
        self._frames += frames

    def measure(self, located: Located, diameter: float) -> None:
        """Take in a circle that was found, where the zoom's ``diameter`` is known to be so many px."""
        measured = offset(located.boundary.center, self._place(diameter))
        if measured is None:
            return
        spec = self._spec
        frames, self._frames = self._frames, 0.0
        # A circle of which an arc is seen has its centre off as its diameter is.
        astray = abs(located.boundary.diameter - diameter) / 2
        variance = max(spec.floor * diameter, located.center_sigma, astray) ** 2
        if self._estimate is None:
            self._take(measured, variance)
        else:
            kept = (1 - spec.forgetting) ** frames
            self._wander2 = max(spec.wander**2, kept * self._wander2)
            wandered = self._variance + frames * self._wander2 * diameter**2
            self._variance = min(wandered, (spec.play * diameter) ** 2)
            total = self._variance + variance
            off = self._distance(measured, self._estimate)
            if off > spec.gate * math.sqrt(total):
                self._wait(measured, variance, diameter, frames)
                return
            self._waiting.clear()
            if off > spec.surprise * math.sqrt(total):
                self._wander2 = max(self._wander2, (off / diameter) ** 2)
            gain = self._variance / total
            (x, y), (a, b) = self._estimate, measured
            self._estimate = x + gain * (a - x), y + gain * (b - y)
            self._variance *= 1 - gain
        self._show(diameter)

    def _take(self, measured: Offset, variance: float) -> None:
        self._estimate, self._variance = measured, variance
        self._waiting.clear()

    def _wait(self, measured: Offset, variance: float, diameter: float, frames: float) -> None:
        """Keep what is far off until others agree with it; then believe the last, and that it may move on."""
        spec = self._spec
        apart = self._distance(measured, self._waiting[-1]) if self._waiting else 0.0
        if apart > spec.fastest * diameter * max(frames, 1.0):
            self._waiting.clear()
        self._waiting.append(measured)
        if len(self._waiting) >= spec.patience:
            self._wander2 = max(self._wander2, (apart / diameter) ** 2)
            self._take(measured, variance)
            self._show(diameter)

    def _show(self, diameter: float) -> None:
        assert self._estimate is not None
        least, most = (part * diameter for part in self._spec.still)
        slack = min(max(least, 2 * math.sqrt(self._variance)), most)
        if self._distance(self._estimate, self._shown) > slack:
            self._shown = self._estimate

    def _distance(self, a: Offset, b: Offset) -> float:
        """How far two offsets are apart, px of the height."""
        return math.hypot((a[0] - b[0]) * self._aspect, a[1] - b[1])


def offset(center: Offset, place: Offset | None) -> Offset | None:
    """Return how far a circle's ``center`` lies from its ``place``, (x, y) px; None if it has none."""
    return None if place is None else (center[0] - place[0], center[1] - place[1])


def shifted(model: DivisionModel, shift: Offset) -> DivisionModel:
    """Return the model with its centre moved by ``shift`` (x, y) px."""
    x, y = model.center
    return replace(model, center=(x + shift[0], y + shift[1]))
