"""Frames inside larger frames, plane by plane."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..remap.layout import FrameLayout

Planes = Sequence[np.ndarray]


class Place:
    """Where the planes of a frame lie in a larger one, at a luma offset (x, y)."""

    def __init__(self, layout: FrameLayout, offset: tuple[int, int]) -> None:
        self._slices = []
        for plane in layout.planes:
            x, y = offset[0] // plane.step[0], offset[1] // plane.step[1]
            rows, columns = plane.shape
            start = x * plane.components
            self._slices.append((slice(y, y + rows), slice(start, start + columns)))

    def views(self, out: Planes) -> list[np.ndarray]:
        """Return views of the frame's planes in those of the larger one."""
        return [plane[place] for plane, place in zip(out, self._slices, strict=True)]


def chroma_grid(layout: FrameLayout) -> tuple[int, int]:
    """Return the luma px, (x, y), between places at which all planes have a sample."""
    steps = [p.step for p in layout.planes]
    return max(s[0] for s in steps), max(s[1] for s in steps)


def round_up(value: int, step: int) -> int:
    """Return the least multiple of ``step`` that is not below ``value``."""
    return -(-value // step) * step


def round_down(value: int, step: int) -> int:
    """Return the greatest multiple of ``step`` that is not above ``value``."""
    return value // step * step
