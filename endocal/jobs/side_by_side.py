"""Original and corrected frame side by side, as the article's evaluation showed them (section V-E)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..remap.layout import FrameLayout

Planes = Sequence[np.ndarray]


class SideBySide:
    """A frame with two frames in it, left and right, each centred in height on black.

    ``size`` is (width, height) in luma px. Both lie on whole chroma samples.
    """

    def __init__(self, left: FrameLayout, right: FrameLayout) -> None:
        steps = [p.step for p in left.planes]
        grid = (max(s[0] for s in steps), max(s[1] for s in steps))
        shift = _up(left.size[0], grid[0])
        height = max(left.size[1], right.size[1])
        self.size = (shift + right.size[0], height)
        self._layout = left.resized(self.size)
        self._left = _Place(left, (0, _down((height - left.size[1]) // 2, grid[1])))
        self._right = _Place(right, (shift, _down((height - right.size[1]) // 2, grid[1])))
        self._has_gaps = shift != left.size[0] or left.size[1] != right.size[1]

    def left(self, out: Planes) -> list[np.ndarray]:
        """Return views of the left frame's planes in ``out``."""
        return self._left.views(out)

    def right(self, out: Planes) -> list[np.ndarray]:
        """Return views of the right frame's planes in ``out``."""
        return self._right.views(out)

    def fill_gaps(self, out: Planes) -> None:
        """Make black what neither frame covers; both are to be written after it."""
        if not self._has_gaps:
            return
        for plane, layout in zip(out, self._layout.planes, strict=True):
            black = [value << layout.shift for value in layout.fill]
            plane.reshape(plane.shape[0], -1, layout.components)[...] = black


class _Place:
    """Where the planes of a frame lie in a larger one, at a luma offset (x, y)."""

    def __init__(self, layout: FrameLayout, offset: tuple[int, int]) -> None:
        self._slices = []
        for plane in layout.planes:
            x, y = offset[0] // plane.step[0], offset[1] // plane.step[1]
            rows, columns = plane.shape
            start = x * plane.components
            self._slices.append((slice(y, y + rows), slice(start, start + columns)))

    def views(self, out: Planes) -> list[np.ndarray]:
        return [plane[place] for plane, place in zip(out, self._slices, strict=True)]


def _up(value: int, step: int) -> int:
    return -(-value // step) * step


def _down(value: int, step: int) -> int:
    return value // step * step
