"""The registry of measures: what Algorithm 1 can minimise, by the names of the command line."""

from __future__ import annotations

from collections.abc import Callable

from ..errors import UsageError
from .hough import Voters, hewg
from .straightness import Floats

# (voters, lams, xs, ys) -> costs (len(lams), len(xs), len(ys)).
GridMeasure = Callable[[Voters, Floats, Floats, Floats], Floats]

MEASURES: dict[str, GridMeasure] = {"hewg": hewg}


def measure_named(name: str) -> GridMeasure:
    """Return the measure of that name; UsageError lists the names there are."""
    try:
        return MEASURES[name]
    except KeyError:
        raise UsageError(f"--method {name}: one of {', '.join(MEASURES)} is needed") from None
