"""The registry of measures: what Algorithm 1 can minimise, by the names of the command line."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from ..errors import UsageError
from .hough import Voters, hewg
from .methods import cht, heplp, hewog, ht1d
from .search import Measure
from .straightness import Floats

# (points (n, 2) px, gradients (n, 2), the frame's size (width, height) px) -> the measure over them.
Prepare = Callable[[Floats, Floats, tuple[float, float]], Measure]


@dataclass(frozen=True)
class NamedMeasure:
    """How a measure is made from edge points, and how many of them it takes at most."""

    prepare: Prepare
    most_points: int = 16_000


def _hewg(points: Floats, gradients: Floats, size: tuple[float, float]) -> Measure:
    return partial(hewg, Voters.of(points, gradients, size[1]))


MEASURES = {
    "hewg": NamedMeasure(_hewg),
    "heplp": NamedMeasure(heplp.prepare, heplp.MOST_POINTS),
    "hewog": NamedMeasure(hewog.prepare, hewog.MOST_POINTS),
    "ht1d": NamedMeasure(ht1d.prepare),
    "cht": NamedMeasure(cht.prepare, cht.MOST_POINTS),
}


def measure_named(name: str) -> NamedMeasure:
    """Return the measure of that name; UsageError lists the names there are."""
    try:
        return MEASURES[name]
    except KeyError:
        raise UsageError(f"--method {name}: one of {', '.join(MEASURES)} is needed") from None
