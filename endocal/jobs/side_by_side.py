"""Original and corrected frame side by side, as the article's evaluation showed them (section V-E)."""

from __future__ import annotations

import numpy as np

from ..remap.layout import FrameLayout
from .placing import Place, Planes, chroma_grid, round_down, round_up


class SideBySide:
    """A frame with two frames in it, left and right, each centred in height on black.

    ``size`` is (width, height) in luma px. Both lie on whole chroma samples.
    """

    def __init__(self, left: FrameLayout, right: FrameLayout) -> None:
        grid = chroma_grid(left)
        shift = round_up(left.size[0], grid[0])
        height = max(left.size[1], right.size[1])
        self.size = (shift + right.size[0], height)
        self._layout = left.resized(self.size)
        self._left = Place(left, (0, round_down((height - left.size[1]) // 2, grid[1])))
        self._right = Place(right, (shift, round_down((height - right.size[1]) // 2, grid[1])))
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
