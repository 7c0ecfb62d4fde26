"""The lens for frames of a given shape, and where each frame's model comes from."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Protocol

import numpy as np

from ..boundary.circle import Boundary
from ..calibration.result import Calibration
from ..errors import InputError
from ..model import DivisionModel, rescaled_place
from ..zoom.table import ZoomTable
from .fixed_lens import FixedModel
from .zoom_log import RecordedZoom, ZoomLog

Lens = Calibration | ZoomTable

# Two shapes are the same where they differ by less than the rounding of a small frame's side.
_SAME_SHAPE = 0.01
# Two pixel aspects are the same: 16:15 and 59:54, both in use for the same video, differ by 2.4 %.
_SAME_ASPECT = 0.03


class ModelSource(Protocol):
    """Gives the model of each frame, asked in the order of the frames.

    ``models`` span what may come and ``boundaries`` are their visible circles, to lay out the output;
    ``sources`` counts the frames by where their zoom came from, ``diameters`` are the least and the greatest
    of the visible circle so far, px (None without a zoom), and ``notes`` says what was assumed.
    """

    models: tuple[DivisionModel, ...]
    boundaries: tuple[Boundary | None, ...]
    sources: Counter[str]
    diameters: tuple[float, float] | None
    notes: list[str]

    def model(self, luma: Callable[[], np.ndarray], time_s: float | None) -> DivisionModel:
        """Return the model for a frame.

        ``luma`` gives it as (h, w) uint8 or uint16, which may take work, where it is looked at; ``time_s``
        is in seconds.
        """
        ...


def model_source(
    lens: Lens,
    lookup: str = "auto",
    center: str = "auto",
    assume_diameter: float | None = None,
    recorded: RecordedZoom | None = None,
    log: ZoomLog | None = None,
    ahead: Callable[[], Iterator[tuple[np.ndarray, float | None]]] | None = None,
) -> ModelSource:
    """Return where the models of frames come from that the lens has been fitted to.

    ``lookup``, ``center`` and ``assume_diameter``: see CorrectionSpec. ``recorded`` is used instead of each
    frame's circle; each frame's zoom goes to ``log``. ``ahead`` gives the luma and the time in s of the
    video's frames from its start on, to look for the first circle where the first frame shows none.
    """
    if not isinstance(lens, ZoomTable):
        return FixedModel(lens, center)
    # Only a zoom table needs the search for the circle, which takes a while to import.
    from .zoom_source import FollowedZoom

    return FollowedZoom(lens, lookup, center, assume_diameter, recorded, log, ahead)


def fit_lens(
    lens: Lens, size: tuple[int, int], pixel_aspect: float | None, name: str
) -> tuple[Lens, str | None]:
    """Fit a lens to frames of ``size`` (width, height) px and say in a note what that took, if anything.

    ``pixel_aspect`` is the frames' (width over height), None where they do not say: then the lens's own
    holds. A lens for the same shape in another number of pixels is rescaled. ``name`` is what messages call
    it. Raises InputError for another shape.
    """
    if isinstance(lens, Calibration):
        held, own = lens.model.size, lens.model.pixel_aspect
    else:
        held, own = lens.size, lens.pixel_aspect
    aspect = own if pixel_aspect is None else pixel_aspect
    same_aspect = abs(math.log(aspect / own)) < _SAME_ASPECT
    if held == size and same_aspect:
        return lens, None
    where = f"{name} holds for {_shape(held, own)}"
    if held == size:
        note = f"{where} and is taken for the video's pixels of {aspect:.4g} instead"
    else:
        shapes = [s[0] * a / s[1] for s, a in ((held, own), (size, aspect))]
        if abs(shapes[0] / shapes[1] - 1) > max(_SAME_SHAPE, 0.0 if same_aspect else _SAME_ASPECT):
            raise InputError(
                f"{where}, but the frames are {_shape(size, aspect)}: another shape; calibrate on a picture"
                " of this video"
            )
        note = f"{where} and is rescaled to {_shape(size, aspect)}"
    scale = (size[0] / held[0], size[1] / held[1])
    return _rescaled(lens, size, scale, aspect), note


def _shape(size: tuple[int, int], aspect: float) -> str:
    pixels = "" if aspect == 1 else f" with pixels of {aspect:.4g}"
    return f"{size[0]}x{size[1]}{pixels}"


def _rescaled(lens: Lens, size: tuple[int, int], scale: tuple[float, float], aspect: float) -> Lens:
    """Rescale a lens by (x, y): lambda with 1/y^2, since it counts in pixels of the height."""
    y = scale[1]
    if isinstance(lens, ZoomTable):
        return ZoomTable(tuple(s.rescale(*scale) for s in lens.settings), size, aspect)
    m, b = lens.model, lens.boundary
    model = DivisionModel(
        m.lam / y**2, rescaled_place(m.center, scale), size, aspect, m.lam2 / y**4
    )
    if b is not None:
        b = Boundary(
            rescaled_place(b.center, scale), b.diameter * y, b.area * scale[0] * y, b.visible
        )
    radius = None if lens.usable_radius is None else lens.usable_radius * y
    return replace(lens, model=model, boundary=b, usable_radius=radius)
