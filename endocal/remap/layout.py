"""How a frame's pixel format lies in memory: planes, sample grids, depth and black.

A plane is a 2-D array (rows, columns * components) of uint8 or uint16, with any number of bytes from
row to row. Each plane has its own sample grid, laid over the frame's luma pixels by a step and an origin:
chroma sample (i, j) of a subsampled format sits at luma coordinate (origin + step * index).
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from ..errors import InputError

# Chroma location -> (horizontal, vertical) position inside its block of luma pixels, 0 first, 1 last.
# The names are FFmpeg's; ITU-T H.273 numbers the same places.
_CHROMA_LOCATIONS = {
    "left": (0.0, 0.5),
    "center": (0.5, 0.5),
    "topleft": (0.0, 0.0),
    "top": (0.5, 0.0),
    "bottomleft": (0.0, 1.0),
    "bottom": (0.5, 1.0),
    # Untagged streams: where MPEG-2 and H.264 put it.
    "unspecified": (0.0, 0.5),
}

_SUBSAMPLING = {
    "420": (2, 2),
    "422": (2, 1),
    "444": (1, 1),
    "440": (1, 2),
    "411": (4, 1),
    "410": (4, 4),
}
_PLANAR = re.compile(r"yuv(?P<alpha>a?)(?P<jpeg>j?)(?P<sub>4\d\d)p(?P<depth>9|10|12|14|16)?(le)?")
_GREY = re.compile(r"gray(?P<depth>9|10|12|14|16)?(le)?")
_SEMIPLANAR8 = re.compile(r"nv(?P<code>12|21|16|24)")
_SEMIPLANAR = re.compile(r"p(?P<code>[024])(?P<depth>10|12|16)(le)?")
_PLANAR_RGB = re.compile(r"gbr(?P<alpha>a?)p(?P<depth>9|10|12|14|16)?(le)?")
_PACKED_RGB = re.compile(
    r"(?P<order>rgb|bgr|rgba|bgra|argb|abgr|rgb0|bgr0|0rgb|0bgr)(?P<bits>24|48|64)?(le)?"
)


@dataclass(frozen=True)
class PlaneLayout:
    """One plane: its grid of samples and what a sample holds.

    ``size`` is (columns, rows) in samples; ``components`` values lie side by side in each sample (2 for
    NV12's chroma, 3 for packed RGB). ``depth`` bits count, shifted left by ``shift`` in the stored word
    (6 for P010). ``step`` is in luma px per sample and ``origin`` the luma coordinate of sample (0, 0),
    both (x, y). ``fill`` is black, one value of ``depth`` bits (not shifted) per component.
    """

    size: tuple[int, int]
    components: int
    depth: int
    step: tuple[int, int]
    origin: tuple[float, float]
    fill: tuple[int, ...]
    shift: int = 0

    @property
    def dtype(self) -> np.dtype:
        """The dtype of a stored word: uint8 or uint16."""
        return np.dtype(np.uint8 if self.depth + self.shift <= 8 else np.uint16)

    @property
    def shape(self) -> tuple[int, int]:
        """The shape of the plane as a 2-D array."""
        return self.size[1], self.size[0] * self.components

    @property
    def maximum(self) -> int:
        """The largest value of a component, before the shift."""
        return (1 << self.depth) - 1


@dataclass(frozen=True)
class FrameLayout:
    """A frame: its pixel format's name, its size in luma px, and its planes in the order of FFmpeg."""

    pix_fmt: str
    size: tuple[int, int]
    full_range: bool
    chroma_location: str
    planes: tuple[PlaneLayout, ...]

    def resized(self, size: tuple[int, int]) -> FrameLayout:
        """Return the layout of the same format at another size."""
        return frame_layout(
            self.pix_fmt,
            size,
            full_range=self.full_range,
            chroma_location=self.chroma_location,
        )

    def empty(self) -> list[np.ndarray]:
        """Allocate the planes of one frame, not initialised."""
        return [np.empty(p.shape, p.dtype) for p in self.planes]


def frame_layout(
    pix_fmt: str,
    size: tuple[int, int],
    *,
    full_range: bool,
    chroma_location: str = "left",
) -> FrameLayout:
    """Describe a frame of an FFmpeg pixel format.

    ``size`` is (width, height) in luma px. ``full_range`` chooses black for luma (0, or 16 scaled by the
    depth); it does not matter for RGB. ``chroma_location`` is FFmpeg's name: left, center, topleft, top,
    bottomleft, bottom or unspecified (taken as left). Raises InputError for a format without a layout here.
    """
    w, h = (int(v) for v in size)
    if w < 1 or h < 1:
        raise InputError(f"a frame of {w}x{h} has no pixels")
    if chroma_location not in _CHROMA_LOCATIONS:
        known = ", ".join(_CHROMA_LOCATIONS)
        raise InputError(f"chroma location {chroma_location!r} is unknown; it is one of {known}")
    planes = _planes(pix_fmt, w, h, full_range, _CHROMA_LOCATIONS[chroma_location])
    if planes is None:
        raise InputError(
            f"pixel format {pix_fmt} cannot be remapped as it is;"
            " convert to one such as yuv420p, yuv444p10le, gray, nv12 or rgb24"
        )
    return FrameLayout(pix_fmt, (w, h), bool(full_range), chroma_location, tuple(planes))


def supported(pix_fmt: str) -> bool:
    """Tell whether ``frame_layout`` knows the pixel format."""
    return _planes(pix_fmt, 16, 16, False, (0.0, 0.5)) is not None


def _planes(
    pix_fmt: str, w: int, h: int, full: bool, location: tuple[float, float]
) -> list[PlaneLayout] | None:
    """The planes of a format, or None where it is unknown."""

    def luma(depth: int, full: bool, shift: int = 0) -> PlaneLayout:
        black = 0 if full else 16 << (depth - 8)
        return PlaneLayout((w, h), 1, depth, (1, 1), (0.0, 0.0), (black,), shift)

    def chroma(sub: tuple[int, int], components: int, depth: int, shift: int = 0) -> PlaneLayout:
        grid = (-(-w // sub[0]), -(-h // sub[1]))
        origin = (location[0] * (sub[0] - 1), location[1] * (sub[1] - 1))
        grey = (1 << (depth - 1),) * components
        return PlaneLayout(grid, components, depth, sub, origin, grey, shift)

    def whole(depth: int, fill: tuple[int, ...]) -> PlaneLayout:
        return PlaneLayout((w, h), len(fill), depth, (1, 1), (0.0, 0.0), fill)

    if m := _PLANAR.fullmatch(pix_fmt):
        if m["sub"] not in _SUBSAMPLING:
            return None
        depth = int(m["depth"] or 8)
        full = full or bool(m["jpeg"])
        cb = chroma(_SUBSAMPLING[m["sub"]], 1, depth)
        # Outside the content is opaque black, so alpha is filled with its maximum.
        return [luma(depth, full), cb, cb] + ([whole(depth, (2**depth - 1,))] if m["alpha"] else [])
    if m := _GREY.fullmatch(pix_fmt):
        return [luma(int(m["depth"] or 8), full)]
    if m := _SEMIPLANAR8.fullmatch(pix_fmt):
        sub = {"12": (2, 2), "21": (2, 2), "16": (2, 1), "24": (1, 1)}[m["code"]]
        return [luma(8, full), chroma(sub, 2, 8)]
    if m := _SEMIPLANAR.fullmatch(pix_fmt):
        sub = {"0": (2, 2), "2": (2, 1), "4": (1, 1)}[m["code"]]
        depth = int(m["depth"])
        # The bits that count are the upper ones of each 16-bit word.
        return [luma(depth, full, 16 - depth), chroma(sub, 2, depth, 16 - depth)]
    if m := _PLANAR_RGB.fullmatch(pix_fmt):
        depth = int(m["depth"] or 8)
        alpha = [whole(depth, (2**depth - 1,))] if m["alpha"] else []
        return [whole(depth, (0,))] * 3 + alpha
    if m := _PACKED_RGB.fullmatch(pix_fmt):
        order, bits = m["order"], m["bits"]
        depth = 16 if bits in ("48", "64") else 8
        if bits != {(3, 8): "24", (3, 16): "48", (4, 16): "64"}.get((len(order), depth)):
            return None
        return [whole(depth, tuple(2**depth - 1 if c == "a" else 0 for c in order))]
    return None
