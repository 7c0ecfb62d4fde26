"""How zoom and eye move over a clip."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.interpolate import PchipInterpolator

from ..errors import UsageError
from .tissue import Eye


@dataclass(frozen=True)
class ZoomPath:
    """Zooms at given times: (s, zoom) pairs with increasing times.

    The zoom's logarithm goes through them smoothly and never beyond its neighbours: it passes through the
    ones in the middle of a rise, turns gently at the highest, rests between equals, and stays before the
    first and after the last.
    """

    keys: tuple[tuple[float, float], ...]

    def __post_init__(self) -> None:
        if not self.keys or any(zoom <= 0 for _, zoom in self.keys):
            raise UsageError("a zoom path needs zooms, each above 0")
        if any(b[0] <= a[0] for a, b in pairwise(self.keys)):
            raise UsageError("the times of a zoom path must increase")

    def at(self, time: float) -> float:
        """Return the zoom at ``time``, s."""
        times, zooms = zip(*self.keys, strict=True)
        # A rest on either side makes it start and end gently, too.
        times = (times[0] - 1, *times, times[-1] + 1)
        curve = PchipInterpolator(times, np.log([zooms[0], *zooms, zooms[-1]]))
        return float(np.exp(curve(min(max(time, times[0]), times[-1]))))


def zoom_path(zooms: Sequence[float], duration: float) -> ZoomPath:
    """Return the path through ``zooms``, evenly spread over ``duration`` s; equal neighbours are a rest."""
    step = duration / max(len(zooms) - 1, 1)
    return ZoomPath(tuple((i * step, z) for i, z in enumerate(zooms)))


@dataclass(frozen=True)
class CouplerPlay:
    """A scope that wanders in its coupler: the picture moves on the sensor, by up to ``reach`` (x, y) px.

    It starts from rest, and along x it takes ``period`` s to go there and back.
    """

    reach: tuple[float, float] = (0.0, 0.0)
    period: float = 7.0

    def at(self, time: float) -> tuple[float, float]:
        """Return the shift (x, y) at ``time`` s, px of the frame."""
        phase = 2 * math.pi * time / self.period
        x, y = ((1 - math.cos(rate * phase)) / 2 for rate in (1.0, 1.3))
        return self.reach[0] * x, self.reach[1] * y


@dataclass(frozen=True)
class EyeMotion:
    """A held endoscope: it sways, and may go towards the tissue and back.

    ``sway`` (x, y, z) in units of the distance to the tissue, ``turn`` (yaw, pitch, roll) in degrees, both
    amplitudes with ``period`` s; ``approach`` is how far it has gone towards the tissue by the middle of
    ``duration`` s.
    """

    sway: tuple[float, float, float] = (0.0, 0.0, 0.0)
    turn: tuple[float, float, float] = (0.0, 0.0, 0.0)
    period: float = 6.0
    approach: float = 0.0
    duration: float = 1.0

    def at(self, time: float) -> Eye:
        """Return the eye at ``time``, s."""
        phase = 2 * math.pi * time / self.period

        def swing(rate: float, start: float) -> float:
            return math.sin(rate * phase + start)

        x, y, z = self.sway
        yaw, pitch, roll = self.turn
        near = self.approach * math.sin(math.pi * min(max(time / self.duration, 0), 1)) ** 2
        return Eye(
            (x * swing(1.0, 0.0), y * swing(0.8, 1.0), z * swing(0.6, 2.0) + near),
            yaw * swing(0.9, 0.5),
            pitch * swing(0.7, 2.5),
            roll * swing(0.5, 4.0),
        )
