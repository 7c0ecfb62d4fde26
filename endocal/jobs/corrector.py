"""From the planes of a frame to those of the output: one view, two eyes, or before and after."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import partial

import numpy as np

from ..errors import InputError
from ..remap.engine import FrameRemapper, Pending
from ..remap.geometry import OutputGeometry, output_geometry
from ..remap.layout import FrameLayout, frame_layout
from ..video.frames import Frame, luma_view, plane_views
from ..video.stream import StreamInfo
from ..video.writer import OutputPicture
from .correction import CorrectionSpec
from .lens import ModelSource
from .placing import Place, chroma_grid
from .side_by_side import SideBySide

# How many eyes a frame holds beside and below each other.
_ARRANGEMENTS = {None: (1, 1), "sbs": (2, 1), "tb": (1, 2)}


class Split:
    """A frame as one view, or as those of two eyes side by side (``sbs``) or one below the other (``tb``).

    ``layout`` is that of one view. Raises InputError for a frame that cannot be halved.
    """

    def __init__(self, info: StreamInfo, stereo: str | None) -> None:
        self._arrangement = _ARRANGEMENTS[stereo]
        whole = frame_layout(
            info.pix_fmt,
            info.size,
            full_range=info.full_range,
            chroma_location=info.colour.chroma_location or "unspecified",
        )
        for size, count, step in zip(
            whole.size, self._arrangement, chroma_grid(whole), strict=True
        ):
            if size % (count * (step if count > 1 else 1)):
                raise InputError(
                    f"a {info.pix_fmt} frame of {whole.size[0]}x{whole.size[1]} cannot be halved for"
                    f" --stereo {stereo}"
                )
        columns, rows = self._arrangement
        self.layout = whole.resized((whole.size[0] // columns, whole.size[1] // rows))
        self._places = self.places(self.layout)

    def places(self, layout: FrameLayout) -> list[Place]:
        """Return where the views of this layout lie in a whole frame."""
        columns, rows = self._arrangement
        w, h = layout.size
        return [Place(layout, (x * w, y * h)) for y in range(rows) for x in range(columns)]

    def whole(self, size: tuple[int, int]) -> tuple[int, int]:
        """Return the size of a whole frame whose views have this size."""
        return size[0] * self._arrangement[0], size[1] * self._arrangement[1]

    def views(self, planes: Sequence[np.ndarray]) -> list[list[np.ndarray]]:
        """Return the planes of each view in those of a whole frame."""
        return [place.views(planes) for place in self._places]

    def luma(self, frame: Frame, eye: int) -> np.ndarray:
        """Return the brightness of one view, (h, w) uint8 or uint16."""
        return self.cut(luma_view(frame), eye)

    def cut(self, picture: np.ndarray, eye: int) -> np.ndarray:
        """Return one view's part of a whole frame (h, w, …) that has a pixel for each of the luma."""
        w, h = self.layout.size
        column, row = eye % self._arrangement[0], eye // self._arrangement[0]
        return picture[row * h : (row + 1) * h, column * w : (column + 1) * w]


class Corrector:
    """Corrects frames; ``eyes`` are the views' model sources, and ``picture`` says what comes out."""

    def __init__(
        self, spec: CorrectionSpec, info: StreamInfo, split: Split, eyes: Sequence[ModelSource]
    ) -> None:
        self._split = split
        self._eyes = eyes
        geometry = stream_geometry(spec, split.layout, eyes)
        self._remappers = [
            FrameRemapper(split.layout, geometry, spec.interpolation, spec.device) for _ in eyes
        ]
        out = self._remappers[0].output_layout
        self._places = split.places(out)
        self._beside = SideBySide(split.layout, out) if spec.side_by_side else None
        size = split.whole(geometry.size) if self._beside is None else self._beside.size
        aspect = info.sample_aspect
        if geometry.pixel_aspect != (1.0 if aspect is None else float(aspect)):
            aspect = Fraction(geometry.pixel_aspect).limit_denominator(1000)
        self.picture = OutputPicture(size, info.pix_fmt, aspect, size_asked=spec.size is not None)

    @property
    def device(self) -> str:
        """The name of the device that remaps."""
        return self._remappers[0].device_name

    def start(self, frame: Frame, target: Frame) -> list[Pending]:
        """Begin to fill the frame ``target`` from the next frame of the input; it is filled after the waits.

        So a device with memory of its own has the next frame on its way while this one comes back.
        """
        planes, out = plane_views(frame), plane_views(target)
        if self._beside is not None:
            self._beside.fill_gaps(out)
            for plane, view in zip(planes, self._beside.left(out), strict=True):
                view[...] = plane
        under_way = []
        for eye, source in enumerate(self._eyes):
            model = source.model(partial(self._split.luma, frame, eye), frame.time)
            place = self._places[eye]
            whole = place.views(out) if self._beside is None else self._beside.right(out)
            remapper = self._remappers[eye]
            pending = remapper.submit(model, self._split.views(planes)[eye], whole)
            if remapper.is_staged:
                under_way.append(pending)
            else:
                # Nothing travels; waiting here lets go of the frame at once.
                pending.wait()
        return under_way


def stream_geometry(
    spec: CorrectionSpec, layout: FrameLayout, eyes: Sequence[ModelSource]
) -> OutputGeometry:
    """Lay out the output, one for all eyes so that their disparity stays.

    A size that nobody asked for is made to fit whole chroma samples.
    """
    # Beside the original, which keeps its pixels, the corrected frame has to keep them too.
    square = not (spec.keep_sar or spec.side_by_side)
    models = [model for eye in eyes for model in eye.models]
    boundaries = [boundary for eye in eyes for boundary in eye.boundaries]

    def lay_out(size: tuple[int, int] | None, scale: float | None) -> OutputGeometry:
        return output_geometry(models, boundaries, spec.view, size, scale, square_pixels=square)

    geometry = lay_out(spec.size, spec.scale)
    w, h = (n + n % step for n, step in zip(geometry.size, chroma_grid(layout), strict=True))
    if spec.size is not None or geometry.size in ((w, h), layout.size):
        return geometry
    return lay_out((w, h), None)
