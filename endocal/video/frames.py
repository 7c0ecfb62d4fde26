"""Frames as arrays: views of their planes, and a pool of frames to write into."""

from __future__ import annotations

from collections import deque
from typing import Any

import av
import numpy as np

# Packed formats whose pixel has a byte that carries nothing, and so no component of its own.
_PADDED = {"bgr0": 4, "rgb0": 4, "0bgr": 4, "0rgb": 4}


def plane_views(frame: av.VideoFrame) -> list[np.ndarray]:
    """Return the frame's planes as arrays (rows, columns * components), uint8 or uint16, without a copy.

    The arrays stay valid as long as they live; writing into them writes into the frame.
    """
    fmt = frame.format
    views = []
    for i, plane in enumerate(frame.planes):
        parts = [c for c in fmt.components if c.plane == i]
        dtype = np.dtype(np.uint16 if parts[0].bits > 8 else np.uint8)
        components = _PADDED.get(fmt.name, len(parts))
        memory: Any = plane
        rows = np.frombuffer(memory, dtype).reshape(plane.height, -1)
        if plane.line_size < 0:
            rows = rows[::-1]
        views.append(rows[:, : plane.width * components])
    return views


class FramePool:
    """Frames of one size and format, used again once they have been encoded.

    A new frame costs a page fault for each of its pages; one that has been touched before does not.
    """

    def __init__(self, size: tuple[int, int], pix_fmt: str) -> None:
        self._size = size
        self._pix_fmt = pix_fmt
        self._free: deque[av.VideoFrame] = deque()

    def take(self) -> av.VideoFrame:
        """Return a frame that may be written; its content is what it was."""
        try:
            frame = self._free.popleft()
        except IndexError:
            return av.VideoFrame(*self._size, self._pix_fmt)
        # An encoder that still reads the frame keeps its memory, and this frame gets its own.
        frame.make_writable()
        return frame

    def give_back(self, frame: av.VideoFrame) -> None:
        """Offer a frame for use again."""
        self._free.append(frame)
