"""The registry of methods, by the names of the command line."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

from ...errors import UsageError
from ..hough.hewg import hewg
from ..hough.votes import Voters
from ..search import Measure
from ..straightness import Floats
from . import cht, corners, heplp, hewog, ht1d, htrdc, wang
from .grid import NamedMeasure
from .task import Method


@dataclass(frozen=True)
class NamedMethod:
    """A method, in a few words, and the entropy that it minimises by Algorithm 1; None where it does not."""

    solve: Method
    title: str
    measure: NamedMeasure | None = None

    @classmethod
    def by(cls, measure: NamedMeasure, title: str) -> NamedMethod:
        """Return the method that minimises an entropy."""
        return cls(measure.solve, title, measure)


def _hewg(points: Floats, gradients: Floats, size: tuple[float, float]) -> Measure:
    return partial(hewg, Voters.of(points, gradients, size[1]))


HEWG = NamedMeasure(_hewg, scouted=True)
_HEPLP = NamedMeasure(heplp.prepare, heplp.MOST_POINTS)
_HEWOG = NamedMeasure(hewog.prepare, hewog.MOST_POINTS)
_HT1D = NamedMeasure(ht1d.prepare)
_CHT = NamedMeasure(cht.prepare, cht.MOST_POINTS)

METHODS: Mapping[str, NamedMethod] = {
    "hewg": NamedMethod.by(HEWG, "Hough entropy, one vote by the undistorted gradient"),
    "heplp": NamedMethod.by(_HEPLP, "Hough entropy in two stages, parallel lines"),
    "hewog": NamedMethod.by(_HEWOG, "Hough entropy, votes for all directions"),
    "ht1d": NamedMethod.by(_HT1D, "entropy of edge directions"),
    "cht": NamedMethod.by(_CHT, "entropy of a cascaded Hough transform"),
    "htrdc": NamedMethod(htrdc.solve, "largest vote of one line, centre given"),
    "wang": NamedMethod(wang.solve, "circle arcs of chosen lines"),
    "corners": NamedMethod(corners.solve, "corners of a chessboard"),
}


def method_named(name: str) -> NamedMethod:
    """Return the method of that name; UsageError lists the names there are."""
    try:
        return METHODS[name]
    except KeyError:
        raise UsageError(f"--method {name}: one of {', '.join(METHODS)} is needed") from None
