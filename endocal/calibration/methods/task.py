"""What every method is given, and what it gives back."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ..fit.plumb_line import Prior
from ..fit.view import View
from ..search import Found, Region
from ..spec import CalibrationSpec
from ..straightness import Floats

# Edge points that vote at most, drawn evenly, where a measure sets no limit of its own.
MOST_POINTS = 16_000


@dataclass(frozen=True)
class Task:
    """The pictures of one lens, and where its model is to be sought; lengths in square px.

    ``size`` is the frame's (width, height); ``region`` bounds lambda and the centre, ``prior`` is what is
    believed of the centre, and whether it is given. ``lines`` are points (n, 2) of each line that somebody
    chose in the picture; None where nobody did. ``most_points`` is how many edge points may vote.
    """

    views: Sequence[View]
    size: tuple[float, float]
    region: Region
    prior: Prior
    spec: CalibrationSpec
    lines: Sequence[Floats] | None = None
    most_points: int = MOST_POINTS


# Raises CalibrationError where the pictures do not hold what the method needs.
Method = Callable[[Task], Found]
