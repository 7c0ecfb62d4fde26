"""Where each sample of an output plane comes from, in samples of the source plane.

The chain is: output sample -> output luma px -> undistorted px of the source frame -> (model) distorted px
-> source sample. Everything is written as a displacement from the output sample's own index, so that a
model without distortion gives back integers exactly, in single precision too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model import DivisionModel
from .geometry import OutputGeometry
from .layout import FrameLayout, PlaneLayout

Coordinates = NDArray[np.float64]


@dataclass(frozen=True)
class PlaneGrid:
    """The fixed part of one plane's mapping: everything but the model.

    The undistorted place of output sample (i, j), in source samples, is ``(i, j) + shift + stretch * (i, j)``
    where ``stretch`` is 0 for a view at magnification 1.
    """

    source: PlaneLayout
    output: PlaneLayout
    shift: tuple[float, float]
    stretch: tuple[float, float]

    def center(self, model: DivisionModel) -> tuple[float, float]:
        """Return the distortion centre in source samples."""
        (ox, oy), (sx, sy) = self.source.origin, self.source.step
        return (model.center[0] - ox) / sx, (model.center[1] - oy) / sy

    def metric(self, model: DivisionModel) -> tuple[float, float]:
        """Return the square px, of the frame's height, that one source sample spans along x and y."""
        return self.source.step[0] * model.pixel_aspect, float(self.source.step[1])

    def displacement(
        self, model: DivisionModel, rows: slice = slice(None)
    ) -> tuple[Coordinates, Coordinates]:
        """How far the source of each output sample lies from the sample's own index, in source samples.

        Returns two float64 arrays (rows, columns), x and y; NaN where nothing maps there.
        """
        columns, height = self.output.size
        i = np.arange(columns, dtype=np.float64)[None, :]
        j = np.arange(height, dtype=np.float64)[rows][:, None]
        (cx, cy), (mx, my) = self.center(model), self.metric(model)
        ex, ey = self.shift[0] + self.stretch[0] * i, self.shift[1] + self.stretch[1] * j
        dx, dy = (i - cx) + ex, (j - cy) + ey
        excess = model.radial_ratio((dx * mx) ** 2 + (dy * my) ** 2) - 1
        return ex + dx * excess, ey + dy * excess


def plane_grids(layout: FrameLayout, geometry: OutputGeometry) -> tuple[PlaneGrid, ...]:
    """Return the grid of each plane of ``layout`` for an output laid out by ``geometry``."""
    output = layout.resized(geometry.size)
    return tuple(
        PlaneGrid(s, o, *_affine(s, geometry))
        for s, o in zip(layout.planes, output.planes, strict=True)
    )


def _affine(
    plane: PlaneLayout, geometry: OutputGeometry
) -> tuple[tuple[float, float], tuple[float, float]]:
    """The shift and stretch of a plane, from the frame's origin and step."""
    pairs = [
        # Luma px X = o + s i shows the undistorted px g + t X, which is source sample (g + t X - o) / s.
        ((g + (t - 1) * o) / s, t - 1)
        for g, t, o, s in zip(geometry.origin, geometry.step, plane.origin, plane.step, strict=True)
    ]
    return (pairs[0][0], pairs[1][0]), (pairs[0][1], pairs[1][1])
