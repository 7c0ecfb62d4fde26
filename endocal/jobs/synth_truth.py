"""The truth of synthetic pictures and clips, as the files that endocal reads."""

from __future__ import annotations

import numpy as np

from ..boundary.circle import Boundary
from ..calibration.result import Calibration
from ..files.writing import number, rounded
from ..model import DivisionModel
from ..synth.board import BoardScene
from ..synth.camera import ContentCircle
from ..synth.clip import ClipFrame
from ..zoom.table import Setting, ZoomTable
from .synth_scenes import ZoomSpec
from .zoom_log import COLUMNS

HEADER = ",".join(COLUMNS)


def true_calibration(scene: BoardScene) -> Calibration:
    """Return what a perfect calibration of the picture would find."""
    return _calibration(scene.division, scene.circle)


def lens_truth(spec: ZoomSpec) -> ZoomTable | Calibration:
    """Return the lens at the zooms of a spec: a table, or a calibration where there is only one zoom."""
    lens, zooms = spec.lens, sorted(set(spec.zooms))
    if len(zooms) == 1:
        return _calibration(lens.model_at(zooms[0]), lens.circle_at(zooms[0]))
    settings = []
    for zoom in zooms:
        model, circle = lens.model_at(zoom), lens.circle_at(zoom)
        area = true_boundary(circle, model).area
        settings.append(
            Setting(model.lam, model.center, circle.diameter, area, circle=circle.center)
        )
    return ZoomTable(tuple(settings), spec.size)


def frame_row(frame: ClipFrame) -> str:
    """Return a frame's line under ``HEADER``: a zoom log with the truth, finer than any measured one."""
    model = frame.model
    values = (frame.circle.diameter, model.lam, *model.center, *frame.shift)
    diameter, lam, x, y, *shift = (number(rounded(v)) for v in values)
    return f"{frame.index},{float(frame.time):.6f},{diameter},given,{lam},{x},{y},0.0,{','.join(shift)}"


def true_boundary(circle: ContentCircle, model: DivisionModel) -> Boundary:
    """Return a circle with what of it lies in the model's frame."""
    w, h = model.size
    x, y = circle.center
    turn = np.linspace(0, 2 * np.pi, 3600, endpoint=False)
    rim_x = x + circle.diameter / 2 * np.cos(turn) / model.pixel_aspect
    rim_y = y + circle.diameter / 2 * np.sin(turn)
    seen = (np.abs(rim_x - (w - 1) / 2) <= w / 2) & (np.abs(rim_y - (h - 1) / 2) <= h / 2)
    passed = circle.transmission(model.size, model.pixel_aspect)
    area = float(passed.sum(dtype=np.float64))
    return Boundary(circle.center, circle.diameter, round(area, 1), float(seen.mean()))


def _calibration(model: DivisionModel, circle: ContentCircle | None) -> Calibration:
    return Calibration(model, boundary=true_boundary(circle, model) if circle else None)
