"""Follow the zoom through a video: the circle of each frame, over time, to the model of each frame."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..boundary.circle import Boundary
from ..boundary.detect import BoundarySpec, boundary_of, locate_boundary
from ..errors import InputError
from ..model import DivisionModel
from .smooth import DiameterFilter, SmoothingSpec
from .table import LOOKUPS, ZoomTable

Luma = NDArray[np.uint8] | NDArray[np.uint16]

SOURCES = ("rim", "tracked", "held", "given")


@dataclass(frozen=True)
class FollowSpec:
    """How a zoom is followed.

    ``lookup`` is one of LOOKUPS. ``assume_diameter`` (px) holds until a rim is seen, to within
    ``assumed_sigma`` (relative). A still estimate has to leave ``still`` (relative) before the model
    changes. Held without any sight of the zoom, the estimate grows less certain by ``drift`` per frame.
    """

    lookup: str = "auto"
    assume_diameter: float | None = None
    assumed_sigma: float = 0.05
    still: float = 4e-4
    drift: float = 2e-3
    boundary: BoundarySpec = field(default_factory=BoundarySpec)
    smoothing: SmoothingSpec = field(default_factory=SmoothingSpec)

    def __post_init__(self) -> None:
        if self.lookup not in LOOKUPS:
            raise ValueError(f"lookup {self.lookup!r} is none of {', '.join(LOOKUPS)}")


@dataclass(frozen=True)
class ZoomEstimate:
    """The zoom of one frame.

    ``boundary`` is the circle that was found in this very frame, if any; ``diameter`` (px) is the estimate.
    ``source`` is one of SOURCES: from the rim, tracked from the picture, held from before, or given.
    ``relative_uncertainty`` is one standard deviation of the diameter; of lambda it is twice that.
    """

    model: DivisionModel
    boundary: Boundary | None
    diameter: float
    source: str
    relative_uncertainty: float


class ZoomFollower:
    """The zoom of a video, frame by frame, for a table that fits its frames' size."""

    def __init__(self, table: ZoomTable, spec: FollowSpec = FollowSpec()) -> None:
        self._table = table
        self._spec = spec
        self._filter = DiameterFilter(spec.smoothing)
        self._last: Boundary | None = None
        self._current: tuple[float, DivisionModel] | None = None
        if spec.assume_diameter is not None:
            self._filter.restart(spec.assume_diameter, spec.assumed_sigma)
        self._is_assumed = spec.assume_diameter is not None

    def update(self, luma: Luma, time_s: float | None = None) -> ZoomEstimate:
        """Return the estimate for the next frame, ``luma`` (h, w) uint8 or uint16.

        Raises InputError for a frame of another size, and while no rim has been seen and none is assumed.
        """
        size = (luma.shape[1], luma.shape[0])
        if size != self._table.size:
            raise InputError(
                f"the zoom table is for frames of {self._table.size[0]}x{self._table.size[1]},"
                f" not {size[0]}x{size[1]}: rescale it"
            )
        located = locate_boundary(
            luma, self._table.pixel_aspect, self._spec.boundary, guess=self._last
        )
        boundary = None if located is None else located.boundary
        self._last = boundary
        source = self._advance(boundary, 0.0 if located is None else located.diameter_sigma, time_s)
        return self._estimate(boundary, source)

    def _advance(self, boundary: Boundary | None, sigma: float, time_s: float | None) -> str:
        """Take in what this frame showed, and name where the estimate comes from."""
        state = self._filter
        if not state.known or (self._is_assumed and boundary is not None):
            if boundary is None:
                raise InputError(_nothing_known(time_s))
            state.restart(boundary.diameter, max(sigma / boundary.diameter, 1e-3))
            self._is_assumed = False
            return "rim"
        if boundary is not None:
            state.predict()
            if state.correct(boundary.diameter, sigma / boundary.diameter):
                return "rim"
            return "held"
        state.stop()
        state.scale(0.0, self._spec.drift)
        return "given" if self._is_assumed else "held"

    def _estimate(self, boundary: Boundary | None, source: str) -> ZoomEstimate:
        state = self._filter
        diameter = state.diameter
        if self._current is not None:
            moved = abs(math.log(diameter / self._current[0]))
            slack = (
                self._spec.still / 4 if state.is_moving else max(self._spec.still, 2 * state.sigma)
            )
            if moved <= slack:
                diameter = self._current[0]
        if self._current is None or diameter != self._current[0]:
            self._current = (diameter, self._look_up(diameter, boundary))
        return ZoomEstimate(self._current[1], boundary, diameter, source, state.sigma)

    def _look_up(self, diameter: float, boundary: Boundary | None) -> DivisionModel:
        if self._spec.lookup == "area" and boundary is not None:
            smoothed = boundary_of(
                boundary.center, diameter, self._table.size, self._table.pixel_aspect
            )
            return self._table.at(smoothed, "area")
        return self._table.at_diameter(
            diameter, "diameter" if self._spec.lookup == "area" else self._spec.lookup
        )


def _nothing_known(time_s: float | None) -> str:
    when = "" if time_s is None else f" at {time_s:.2f} s"
    return (
        f"no visible circle{when}, and none before it: the zoom is not known; give --zoom-from or"
        " --assume-diameter"
    )
