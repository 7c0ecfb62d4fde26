"""The reference engine: NumPy in float64, on one core."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..model import DivisionModel
from .grid import Coordinates, PlaneGrid
from .interpolation import first_tap, weights

# Rows resampled at a time: bounds the memory of the float64 intermediates to some tens of MB at 2160p.
_ROWS = 64


class NumpyEngine:
    """Resamples frames in float64."""

    device_name = "numpy"
    staged = False

    def __init__(self, grids: Sequence[PlaneGrid], interpolation: str) -> None:
        self._grids = tuple(grids)
        self._interpolation = interpolation

    def submit(
        self, model: DivisionModel, planes: Sequence[np.ndarray], out: Sequence[np.ndarray]
    ) -> Done:
        """Resample every plane, at once; see FrameRemapper.apply."""
        for grid, source, target in zip(self._grids, planes, out, strict=True):
            for top in range(0, grid.output.size[1], _ROWS):
                rows = slice(top, min(top + _ROWS, grid.output.size[1]))
                dx, dy = grid.displacement(model, rows)
                target[rows] = resample(grid, source, dx, dy, rows, self._interpolation)
        return Done()


class Done:
    """A frame that has arrived."""

    def wait(self) -> None:
        """Return at once."""


def resample(
    grid: PlaneGrid,
    source: np.ndarray,
    dx: Coordinates,
    dy: Coordinates,
    rows: slice,
    interpolation: str,
) -> np.ndarray:
    """Interpolate ``source`` at displacements (rows, columns) from the output's own indices.

    Samples beyond the plane repeat its edge; the result then fades to the fill by the share of a luma
    pixel, centred on the position, that lies outside the frame (for nearest: all or nothing). Returns the
    stored words, (rows, columns * components).
    """
    columns = np.arange(grid.output.size[0])[None, :]
    lines = np.arange(rows.start, rows.stop)[:, None]
    share = _share(grid, columns + dx, lines + dy, interpolation)
    half = 0.5 if interpolation == "nearest" else 0.0
    x, fx = _split(columns, dx, half)
    y, fy = _split(lines, dy, half)
    (w, h), n = grid.source.size, grid.source.components
    samples = source.reshape(h, w, n) if source.flags.c_contiguous else _components(source, n)
    wx, wy = weights(interpolation, fx), weights(interpolation, fy)
    first = first_tap(interpolation)
    value = np.zeros((*dx.shape, n))
    for b in range(len(wy)):
        r = np.clip(y + first + b, 0, h - 1)
        line = np.zeros_like(value)
        for a in range(len(wx)):
            c = np.clip(x + first + a, 0, w - 1)
            line += wx[a][..., None] * (samples[r, c] >> grid.source.shift)
        value += wy[b][..., None] * line
    value = np.clip(value, 0, grid.source.maximum)
    value += (1 - share)[..., None] * (np.array(grid.source.fill, np.float64) - value)
    words = np.floor(value + 0.5).astype(source.dtype) << grid.source.shift
    return words.reshape(len(words), -1)


def _components(source: np.ndarray, n: int) -> np.ndarray:
    """View a plane of padded rows, (rows, columns * n), as (rows, columns, n)."""
    rows, words = source.shape
    s = source.strides
    return np.lib.stride_tricks.as_strided(
        source, (rows, words // n, n), (s[0], s[1] * n, s[1]), writeable=False
    )


def _split(
    index: np.ndarray, displacement: Coordinates, half: float
) -> tuple[np.ndarray, Coordinates]:
    """Whole and fractional part of index + displacement + half; 0 where the displacement is NaN."""
    safe = np.nan_to_num(displacement, nan=0.0, posinf=0.0, neginf=0.0) + half
    whole = np.floor(safe)
    # Far outside everything is fill: keep the index within what an integer holds.
    return index + np.clip(whole, -(2**30), 2**30).astype(np.int64), safe - whole


def _share(grid: PlaneGrid, x: Coordinates, y: Coordinates, interpolation: str) -> Coordinates:
    """How much of a luma pixel centred on source sample (x, y) lies inside the frame, 0 to 1.

    With nearest it is all or nothing: whether the nearest sample exists.
    """
    share = np.ones(np.broadcast(x, y).shape)
    plane = grid.source
    for position, o, s, n in zip((x, y), plane.origin, plane.step, plane.size, strict=True):
        if interpolation == "nearest":
            share = share * ((position >= -0.5) & (position < n - 0.5))
        else:
            # The frame is counted in whole samples: an odd width ends half a chroma sample later.
            luma = o + s * position
            share = share * np.clip(np.minimum(luma + 1, s * n - luma), 0, 1)
    return np.where(np.isnan(share), 0.0, share)
