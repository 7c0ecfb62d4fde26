"""Averages over pixels of a picture that is known everywhere: adaptive supersampling."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Labelling = Callable[[Floats, Floats], NDArray[np.int32]]

# A Fibonacci lattice: for any direction of an edge its points project to well spread positions, so that a
# pixel's coverage is known to about 1/89, against 1/9 for a square grid of as many points.
_POINTS, _STEP = 89, 55
_STRIP_ROWS = 64
_CHUNK = 4096


def lattice() -> tuple[Floats, Floats]:
    """Return the sample offsets in x and in y, (89,) each, within a pixel: -0.5 to 0.5, mean zero."""
    k = np.arange(_POINTS)
    return (k + 0.5) / _POINTS - 0.5, ((k * _STEP) % _POINTS + 0.5) / _POINTS - 0.5


def pixel_averages(
    labelling: Labelling,
    values: NDArray[np.float32],
    origin: tuple[int, int],
    shape: tuple[int, int],
) -> NDArray[np.float32]:
    """Average the value of each label over the area of each pixel.

    ``labelling`` gives the int label at picture positions (x, y) in px; ``values`` (labels, ...) gives
    what a label is worth; the result, float32 (h, w, ...), covers ``shape`` = (h, w) pixels from pixel
    ``origin`` = (x, y) on. A pixel whose four corners have one label is taken to be all of that label.
    """
    h, w = shape
    out = np.empty((h, w, *values.shape[1:]), np.float32)
    corner_x = origin[0] - 0.5 + np.arange(w + 1, dtype=np.float64)
    dx, dy = lattice()
    for top in range(0, h, _STRIP_ROWS):
        bottom = min(h, top + _STRIP_ROWS)
        corner_y = origin[1] - 0.5 + np.arange(top, bottom + 1, dtype=np.float64)
        label = labelling(*np.broadcast_arrays(corner_x[None, :], corner_y[:, None]))
        strip = values[label[:-1, :-1]]
        mixed = (label[:-1, :-1] != label[1:, :-1]) | (label[:-1, :-1] != label[:-1, 1:])
        mixed |= label[1:, 1:] != label[:-1, :-1]
        rows, cols = np.nonzero(mixed)
        for first in range(0, len(rows), _CHUNK):
            part = slice(first, first + _CHUNK)
            x = (cols[part] + origin[0])[:, None] + dx
            y = (rows[part] + top + origin[1])[:, None] + dy
            strip[rows[part], cols[part]] = values[labelling(x, y)].mean(axis=1)
        out[top:bottom] = strip
    return out
