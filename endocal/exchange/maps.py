"""The remapping itself, for tools that take maps: where each pixel of the output comes from."""

from __future__ import annotations

import io

import cv2
import numpy as np
from numpy.typing import NDArray

from ..errors import OutputError
from ..model import DivisionModel
from ..remap.geometry import OutputGeometry
from ..remap.grid import plane_grids
from ..remap.layout import frame_layout

Map = NDArray[np.float64]

# A place far outside every frame, for pixels that show nothing; within the 16 bits of fixed-point maps.
_NOWHERE = -10000.0
_UNMAPPED = 0xFFFF  # for ffmpeg: beyond every frame, so that it takes its fill colour


def source_maps(model: DivisionModel, geometry: OutputGeometry) -> tuple[Map, Map]:
    """Return x and y, float64 (rows, columns): the source px of each output pixel; NaN where none is."""
    layout = frame_layout("gray", geometry.source_size, full_range=True)
    (grid,) = plane_grids(layout, geometry)
    dx, dy = grid.displacement(model)
    columns, rows = geometry.size
    return np.arange(columns) + dx, np.arange(rows)[:, None] + dy


def pgm_maps(x: Map, y: Map, source_size: tuple[int, int]) -> tuple[bytes, bytes]:
    """Return two 16-bit PGM files for ffmpeg's filter ``remap``: the nearest source pixel, or none."""
    indices = [np.floor(np.nan_to_num(m, nan=_NOWHERE) + 0.5) for m in (x, y)]
    shown = np.ones(x.shape, bool)
    for index, n in zip(indices, source_size, strict=True):
        shown &= (index >= 0) & (index < n)
    header = f"P5\n{x.shape[1]} {x.shape[0]}\n65535\n".encode()
    whole = [np.where(shown, index, _UNMAPPED).astype(">u2").tobytes() for index in indices]
    return header + whole[0], header + whole[1]


def stmap_tiff(x: Map, y: Map, source_size: tuple[int, int], depth: int) -> bytes:
    """Return an STMap as TIFF of 32-bit floats or 16-bit integers.

    Red is x and green y as fractions of the source frame, 0 at its left and lower edge and 1 at the
    others, so that pixel i's centre lies at (i + 0.5) / n. Blue is 1 where the output shows the frame, else
    0. Floats tell places outside the frame too, and -1 where there is none; 16 bits are clipped to [0, 1].
    """
    w, h = source_size
    s, t = (x + 0.5) / w, 1 - (y + 0.5) / h
    shown = (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)
    planes = [shown.astype(np.float64), np.nan_to_num(t, nan=-1.0), np.nan_to_num(s, nan=-1.0)]
    picture = np.stack(planes, axis=-1)  # OpenCV's order: blue, green, red
    if depth == 16:
        stored = np.round(np.clip(picture, 0, 1) * 65535).astype(np.uint16)
    else:
        stored = picture.astype(np.float32)
    done, data = cv2.imencode(".tif", stored)
    if not done:
        raise OutputError("the STMap cannot be encoded as TIFF")
    return data.tobytes()


def npz_maps(x: Map, y: Map, model: DivisionModel) -> bytes:
    """Return ``map_x`` and ``map_y``, float32, as ``cv2.remap`` takes them, and ``source_size`` (w, h)."""
    buffer = io.BytesIO()
    maps = [np.nan_to_num(m, nan=_NOWHERE).astype(np.float32) for m in (x, y)]
    np.savez_compressed(buffer, map_x=maps[0], map_y=maps[1], source_size=np.array(model.size))
    return buffer.getvalue()
