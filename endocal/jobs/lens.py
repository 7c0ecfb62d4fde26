"""Where each frame's model comes from: one calibration, or a zoom table and the frame's own circle."""

from __future__ import annotations

from collections import Counter
from typing import Any, Protocol

import numpy as np

from ..boundary.circle import Boundary
from ..calibration.result import Calibration
from ..errors import InputError
from ..model import DivisionModel
from ..zoom.table import ZoomTable

Lens = Calibration | ZoomTable


class ModelSource(Protocol):
    """Gives the model of each frame, asked in the order of the frames.

    ``models`` span what may come and ``boundaries`` are their visible circles, to lay out the output;
    ``sources`` counts the frames by where their zoom came from.
    """

    models: tuple[DivisionModel, ...]
    boundaries: tuple[Boundary | None, ...]
    sources: Counter[str]

    def model(self, luma: np.ndarray, time_s: float | None) -> DivisionModel:
        """Return the model for a frame; ``luma`` is (h, w) uint8 or uint16, ``time_s`` in seconds."""
        ...


class FixedModel:
    """One calibration for all frames."""

    def __init__(self, calibration: Calibration, size: tuple[int, int]) -> None:
        self._model = calibration.model.rescale(size)
        self.models: tuple[DivisionModel, ...] = (self._model,)
        self.boundaries: tuple[Boundary | None, ...] = (
            _scaled(calibration.boundary, calibration.model.size, size),
        )
        self.sources: Counter[str] = Counter()

    def model(self, luma: np.ndarray, time_s: float | None) -> DivisionModel:
        """Return the one model."""
        return self._model


class FollowedZoom:
    """A zoom table, and the visible circle of each frame to look it up by."""

    def __init__(self, table: ZoomTable, size: tuple[int, int]) -> None:
        from ..zoom.follow import ZoomFollower

        table = table.rescale(size)
        self._follower = ZoomFollower(table)
        self.models = tuple(table.at_diameter(s.diameter) for s in table.settings)
        self.boundaries: tuple[Boundary | None, ...] = tuple(
            Boundary(s.center, s.diameter, s.area or 0.0, 1.0) for s in table.settings
        )
        self.sources: Counter[str] = Counter()

    def model(self, luma: np.ndarray, time_s: float | None) -> DivisionModel:
        """Measure the circle in the frame and return the model of its zoom."""
        estimate: Any = self._follower.update(luma, time_s)
        self.sources[estimate.source] += 1
        return estimate.model


def model_source(lens: Lens, size: tuple[int, int]) -> ModelSource:
    """Return where the models of frames of ``size`` come from; InputError for another aspect ratio."""
    return FollowedZoom(lens, size) if isinstance(lens, ZoomTable) else FixedModel(lens, size)


def rescaled_note(lens: Lens, size: tuple[int, int], name: str) -> str | None:
    """Say that the lens is rescaled to frames of another size, or None where it fits as it is.

    ``name`` is what messages call the lens. Raises InputError for another aspect ratio.
    """
    held = lens.size if isinstance(lens, ZoomTable) else lens.model.size
    if held == size:
        return None
    try:
        lens.rescale(size) if isinstance(lens, ZoomTable) else lens.model.rescale(size)
    except InputError as error:
        raise InputError(f"{name}: {error}") from None
    return f"{name} holds for {held[0]}x{held[1]} and was rescaled to {size[0]}x{size[1]}"


def _scaled(
    boundary: Boundary | None, held: tuple[int, int], size: tuple[int, int]
) -> Boundary | None:
    if boundary is None or held == size:
        return boundary
    sx, sy = size[0] / held[0], size[1] / held[1]
    x, y = boundary.center
    return Boundary(
        center=((x + 0.5) * sx - 0.5, (y + 0.5) * sy - 0.5),
        diameter=boundary.diameter * sy,
        area=boundary.area * sx * sy,
        visible=boundary.visible,
    )
