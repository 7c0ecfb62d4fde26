"""The view of the output: which undistorted place each output pixel shows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ..boundary.circle import Boundary
from ..errors import UsageError
from ..model import DivisionModel

VIEWS = ("same", "crop", "full")


@dataclass(frozen=True)
class OutputGeometry:
    """An output frame laid over undistorted coordinates.

    Output pixel (i, j) shows the undistorted point ``origin + step * (i, j)``, in px of the source frame.
    ``size`` is the output's and ``source_size`` the input's (width, height) in px; ``pixel_aspect`` is the
    output's pixel width over its height.
    """

    source_size: tuple[int, int]
    size: tuple[int, int]
    origin: tuple[float, float] = (0.0, 0.0)
    step: tuple[float, float] = (1.0, 1.0)
    pixel_aspect: float = 1.0


def output_geometry(
    models: Sequence[DivisionModel],
    boundaries: Sequence[Boundary | None] | None = None,
    view: str = "same",
    size: tuple[int, int] | None = None,
    scale: float | None = None,
    square_pixels: bool = False,
) -> OutputGeometry:
    """Lay out the output for a stream on which every one of ``models`` may come to hold."""
    if view not in VIEWS:
        raise UsageError(f"view {view!r} is unknown; it is one of {', '.join(VIEWS)}")
    return OutputGeometry(models[0].size, models[0].size, pixel_aspect=models[0].pixel_aspect)
