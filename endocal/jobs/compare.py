"""The methods side by side on pictures: the job behind ``endocal compare``."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from ..calibration.calibrate import calibrate
from ..calibration.evaluate import Evaluation, LinePoints, evaluate
from ..calibration.methods.registry import METHODS
from ..calibration.scene import Image
from ..calibration.spec import METHODS_OF_LINES, CalibrationSpec
from ..errors import CalibrationError, InputError, UsageError
from ..files import read_image
from ..files.names import shown
from ..model import DivisionModel
from .evaluate import check_inside
from .line_source import LineSource

# The row of the default method with its refinement, beside the bare ones.
REFINED = "refined"


@dataclass(frozen=True)
class ComparisonSpec:
    """What to compare: ``methods`` by name, each bare, or each refined with ``refine``.

    REFINED stands for hewg with its refinement. ``seen`` says how the pictures are looked at, ``lines`` on
    what the methods are measured, and what those that take lines are given.
    """

    images: tuple[str, ...]
    methods: tuple[str, ...] = (*METHODS, REFINED)
    refine: bool = False
    lines: LineSource = field(default_factory=LineSource)
    seen: CalibrationSpec = field(default_factory=CalibrationSpec)

    def __post_init__(self) -> None:
        for name in self.methods:
            if name not in (*METHODS, REFINED):
                known = ", ".join((*METHODS, REFINED))
                raise UsageError(f"--method {name}: one of {known} is needed")
        if self.lines.lines is not None and len(self.images) > 1:
            raise UsageError("--lines are those of one picture: give one")

    def of(self, method: str) -> CalibrationSpec:
        """Return how that method is run."""
        if method == REFINED:
            return replace(self.seen, method="hewg", refine=True)
        lines = self.lines.lines if method in METHODS_OF_LINES else None
        return replace(self.seen, method=method, refine=self.refine, lines=lines)


@dataclass(frozen=True)
class Row:
    """A method on a picture: its model and how straight that is, or why it refused; seconds on the clock."""

    image: str
    method: str
    seconds: float
    model: DivisionModel | None = None
    evaluation: Evaluation | None = None
    refused: str | None = None

    def data(self) -> dict[str, Any]:
        """Return the row as plain data; None for what there is not."""
        model, e = self.model, self.evaluation
        return {
            "image": self.image,
            "method": self.method,
            "lambda": None if model is None else model.lam,
            "center_x": None if model is None else model.center[0],
            "center_y": None if model is None else model.center[1],
            "rmse": None if e is None or not math.isfinite(e.rmse) else e.rmse,
            "straightness": None
            if e is None or not math.isfinite(e.straightness)
            else e.straightness,
            "seconds": round(self.seconds, 3),
            "refused": self.refused,
        }


@dataclass(frozen=True)
class Picture:
    """A picture's lines as they are: how many, and how straight, px; None where none were found, and why."""

    image: str
    lines: int = 0
    rmse: float | None = None
    straightness: float | None = None
    without: str | None = None


@dataclass(frozen=True)
class ComparisonReport:
    """The pictures, and a row for each of their methods."""

    pictures: tuple[Picture, ...]
    rows: tuple[Row, ...]

    def data(self) -> dict[str, Any]:
        """Return the report as plain data."""
        return {
            "images": [asdict(picture) for picture in self.pictures],
            "rows": [row.data() for row in self.rows],
        }


def compare(
    spec: ComparisonSpec, progress: Callable[[str], None] = lambda work: None
) -> ComparisonReport:
    """Run each method on each picture, and measure all on the same lines.

    A method that refuses has a row that says why. Raises InputError, naming the file, for one that is no
    usable picture, and CalibrationError where no method found anything, or a picture does not show the board
    to measure on. ``progress`` is told each work.
    """
    images = [read_image(path) for path in spec.images]
    pictures, rows = [], []
    for path, image in zip(spec.images, images, strict=True):
        progress(f"{shown(path)}: lines")
        picture, lines = _lines(path, image, spec)
        pictures.append(picture)
        for method in spec.methods:
            progress(f"{shown(path)}: {method}")
            rows.append(_row(path, image, method, spec, lines))
    if all(row.model is None for row in rows):
        raise CalibrationError(f"{shown(spec.images[0])}: no method: {rows[0].refused}")
    return ComparisonReport(tuple(pictures), tuple(rows))


def _lines(path: str, image: Image, spec: ComparisonSpec) -> tuple[Picture, LinePoints | None]:
    size = (image.shape[1], image.shape[0])
    try:
        lines = spec.lines.find(image, spec.seen)
        check_inside(lines, size)
    except CalibrationError as error:
        # Asked for by name, a board that is not there is an error, as for endocal evaluate.
        if spec.lines.board is not None:
            raise CalibrationError(f"{shown(path)}: {error}") from None
        return Picture(path, without=str(error)), None
    except InputError as error:
        raise InputError(f"{shown(path)}: {error}") from None
    middle = ((size[0] - 1) / 2, (size[1] - 1) / 2)
    found = evaluate(lines, DivisionModel(0.0, middle, size, spec.seen.aspect))
    return Picture(path, found.lines, found.rmse, found.straightness), lines


def _row(
    path: str, image: Image, method: str, spec: ComparisonSpec, lines: LinePoints | None
) -> Row:
    start = time.perf_counter()
    try:
        model = calibrate(image, spec.of(method)).model
    except CalibrationError as error:
        return Row(path, method, time.perf_counter() - start, refused=str(error))
    seconds = time.perf_counter() - start
    return Row(path, method, seconds, model, None if lines is None else evaluate(lines, model))
