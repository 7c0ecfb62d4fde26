"""Frames as arrays: views of their planes, and a pool of frames to write into."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from functools import cache
from typing import Any

import av
import numpy as np

Frame = av.VideoFrame

# Packed formats whose pixel has a byte that carries nothing, and so no component of its own.
_PADDED = {"bgr0": 4, "rgb0": 4, "0bgr": 4, "0rgb": 4}

# Beginnings of the names of formats whose first plane is luma and nothing else.
_LUMA_FIRST = ("gray", "yuv4", "yuva4", "yuvj4", "nv12", "nv16", "nv24", "p010", "p210", "p410")

# Sample depths in bits that formats come in.
_DEPTHS = (8, 9, 10, 12, 14, 16)


def plane_views(frame: av.VideoFrame) -> list[np.ndarray]:
    """Return the frame's planes as arrays (rows, columns * components), uint8 or uint16, without a copy.

    The arrays stay valid as long as they live; writing into them writes into the frame.
    """
    views = []
    for plane, (dtype, components) in zip(frame.planes, _words(frame.format.name), strict=True):
        memory: Any = plane
        rows = np.frombuffer(memory, dtype).reshape(plane.height, -1)
        if plane.line_size < 0:
            rows = rows[::-1]
        views.append(rows[:, : plane.width * components])
    return views


@cache
def _words(pix_fmt: str) -> tuple[tuple[np.dtype, int], ...]:
    """Return each plane's words and how many of them stand side by side for a sample."""
    fmt = av.VideoFormat(pix_fmt)
    planes = []
    for plane in range(max(c.plane for c in fmt.components) + 1):
        parts = [c for c in fmt.components if c.plane == plane]
        dtype = np.dtype(np.uint16 if parts[0].bits > 8 else np.uint8)
        planes.append((dtype, _PADDED.get(pix_fmt, len(parts))))
    return tuple(planes)


def luma_view(frame: av.VideoFrame) -> np.ndarray:
    """Return the frame's brightness, (h, w) uint8 or uint16: its own plane of it, or one made from RGB.

    A palette, packed or RGB frame is turned to 8-bit grey, which copies it.
    """
    if not has_luma_plane(frame.format.name):
        frame = frame.reformat(format="gray")
    return plane_views(frame)[0]


def to_bgr(frame: av.VideoFrame) -> np.ndarray:
    """Return the frame as (h, w, 3) uint8 BGR, by its own matrix and range."""
    return frame.to_ndarray(format="bgr24")


def luma_bits(pix_fmt: str, bits: int) -> int:
    """Return how many bits ``luma_view`` has for a pixel format of ``bits`` a sample."""
    if not has_luma_plane(pix_fmt):
        return 8
    # P010 and its like keep theirs at the upper end of 16.
    return 16 if pix_fmt.startswith(("p0", "p2", "p4")) else bits


def has_luma_plane(pix_fmt: str) -> bool:
    """Tell whether a pixel format's first plane is luma alone."""
    return pix_fmt.startswith(_LUMA_FIRST)


def workable_format(fmt: av.VideoFormat, accepts: Callable[[str], bool]) -> str:
    """Return the pixel format to work in: the frame's own, or else the nearest that holds all of it.

    ``accepts`` tells the formats that can be worked on. The nearest is the same in another arrangement of
    the bytes: planes apart, little-endian, a palette resolved.
    """
    if accepts(fmt.name):
        return fmt.name
    bits = max((c.bits for c in fmt.components), default=8)
    alpha = "a" if fmt.has_palette or any(c.is_alpha for c in fmt.components) else ""
    depth = next((d for d in _DEPTHS if d >= bits), 16)
    suffix = "" if depth == 8 else f"{depth}le"
    if fmt.is_rgb or fmt.has_palette:
        candidates = ["bgra" if alpha else "bgr24"] if depth == 8 else [f"gbr{alpha}p{suffix}"]
    elif len(fmt.components) <= 2:
        candidates = ["gray" + suffix]
    else:
        chroma = fmt.components[1]
        wide, high = 2 * chroma.width > fmt.width + 1, 2 * chroma.height > fmt.height + 1
        sub = {(True, True): "444", (False, True): "422", (False, False): "420"}.get(
            (wide, high), "444"
        )
        candidates = [f"yuv{alpha}{sub}p{suffix}"]
    return next((c for c in candidates if accepts(c)), "yuv444p16le")


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
