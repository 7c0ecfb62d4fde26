"""How straight a lens makes the lines of pictures: the job behind ``endocal evaluate``."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field
from functools import partial
from typing import Any

import cv2
import numpy as np

from ..calibration.evaluate import Evaluation, LinePoints, evaluate
from ..calibration.result import Calibration
from ..calibration.scene import Image
from ..calibration.spec import CalibrationSpec
from ..errors import CalibrationError, InputError, UsageError
from ..files import load, read_image
from ..files.names import shown
from ..model import DivisionModel
from .lens import Lens, fit_lens, model_source
from .line_source import LineSource


@dataclass(frozen=True)
class EvaluationSpec:
    """What to measure: a calibration or zoom table (``-`` is stdin), on pictures of the same lens.

    ``seen`` says how lines are looked for: its roi alone counts.
    """

    calibration: str
    images: tuple[str, ...]
    lines: LineSource = field(default_factory=LineSource)
    seen: CalibrationSpec = field(default_factory=CalibrationSpec)

    def __post_init__(self) -> None:
        if self.lines.lines is not None and len(self.images) > 1:
            raise UsageError("--lines are those of one picture: give one")


@dataclass(frozen=True)
class PictureEvaluation:
    """A picture's straightness under the lens; ``notes`` say what was assumed of the lens."""

    image: str
    evaluation: Evaluation
    notes: tuple[str, ...] = ()

    def data(self) -> dict[str, Any]:
        """Return it as plain data; None where the model folds before a point."""
        values = {k: _finite(v) for k, v in asdict(self.evaluation).items()}
        return {"image": self.image, **values}


@dataclass(frozen=True)
class EvaluationReport:
    """The pictures in order, and all of their points together."""

    pictures: tuple[PictureEvaluation, ...]

    @property
    def total(self) -> Evaluation:
        """The measures over the points of all pictures."""
        found = [p.evaluation for p in self.pictures]
        points = np.array([e.points for e in found])

        def pooled(name: str) -> float:
            values = np.array([getattr(e, name) for e in found])
            return float(np.sqrt((points * values**2).sum() / points.sum()))

        names = ("rmse_before", "rmse", "straightness_before", "straightness")
        return Evaluation(
            sum(e.lines for e in found), int(points.sum()), *(pooled(name) for name in names)
        )

    def data(self) -> dict[str, Any]:
        """Return the report as plain data."""
        total = {k: _finite(v) for k, v in asdict(self.total).items()}
        return {"images": [p.data() for p in self.pictures], "all": total}


def evaluate_files(spec: EvaluationSpec) -> EvaluationReport:
    """Measure how straight a lens makes the lines of each picture.

    A zoom table is looked up by each picture's visible circle. Raises InputError, naming the file, for a
    file that cannot be used or a picture of another shape, CalibrationError for one without lines.
    """
    lens = load(spec.calibration)
    return EvaluationReport(tuple(_of_picture(path, lens, spec) for path in spec.images))


def _of_picture(path: str, lens: Lens, spec: EvaluationSpec) -> PictureEvaluation:
    image = read_image(path)
    name = "<stdin>" if spec.calibration == "-" else shown(spec.calibration)
    try:
        fitted, note = fit_lens(lens, (image.shape[1], image.shape[0]), None, name)
        model = _model(fitted, image)
        lines = spec.lines.find(image, _seen(spec, model))
        check_inside(lines, model.size)
    except (InputError, CalibrationError) as error:
        raise type(error)(f"{shown(path)}: {error}") from None
    return PictureEvaluation(path, evaluate(lines, model), (note,) if note else ())


def _model(lens: Lens, image: Image) -> DivisionModel:
    if isinstance(lens, Calibration):
        return lens.model
    grey: Any = image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    return model_source(lens).model(partial(lambda luma: luma, grey), None)


def _seen(spec: EvaluationSpec, model: DivisionModel) -> CalibrationSpec:
    return CalibrationSpec(roi=spec.seen.roi, pixel_aspect=model.pixel_aspect)


def check_inside(lines: LinePoints, size: tuple[int, int]) -> None:
    """Refuse points off the frame; UsageError names the line."""
    outside = ((lines.points < -0.5) | (lines.points > np.array(size) - 0.5)).any(axis=1)
    if outside.any():
        i = int(outside.argmax())
        x, y = lines.points[i]
        raise UsageError(
            f"--lines: line {lines.labels[i] + 1} leaves the {size[0]}x{size[1]} px picture at {x:g},{y:g}"
        )


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
