"""Every tunable of a calibration, named, with unit and default."""

from __future__ import annotations

import math
from dataclasses import dataclass
from numbers import Integral, Real

from ..errors import UsageError

MODELS = ("division", "division2")

# The methods that take lines which somebody chose.
METHODS_OF_LINES = ("wang", "htrdc")

# Lines shorter than this, px, have no direction.
SHORTEST_LINE = 1.0
# More models a round than the cube of this are no search but a wait, of hours and gigabytes.
MOST_SAMPLES = 100
# Each round narrows the range; long before this it is nothing.
MOST_ROUNDS = 1000
# A pixel's width over its height, least and most: anamorphic pictures stay far within.
PIXEL_ASPECTS = (0.1, 10.0)

Center = str | tuple[float, float]
# Each line as its points (x, y), px of the frame.
Lines = tuple[tuple[tuple[float, float], ...], ...]


@dataclass(frozen=True)
class CalibrationSpec:
    """How to calibrate.

    ``method`` is a name in the registry of methods; ``refine`` turns the plumb-line refinement on.
    ``center`` is "free" (searched), "image" (the frame's centre) or an (x, y) in px to keep.
    ``samples`` per axis of Algorithm 1 (3 to 100) and ``epsilon``, the range of lambda in px^-2 at which it
    stops, are the article's. ``center_region`` is the share of width and height, 0 to 1, in which the centre
    is sought. ``sobel`` is how many px around an edge point tell its direction, the article's size of a mask.
    ``roi`` is (x, y, width, height) in px: edges outside it are ignored. ``model`` is one of MODELS.
    ``pixel_aspect`` is a pixel's width over its height, 0.1 to 10; None where nobody says. ``lines`` are
    lines that somebody chose in the picture, for the methods that take some. Raises UsageError for values
    that make no sense.
    """

    method: str = "hewg"
    refine: bool = True
    center: Center = "free"
    samples: int = 10
    epsilon: float = 1e-9
    max_rounds: int = 20
    center_region: float = 0.1
    sobel: int = 21
    roi: tuple[int, int, int, int] | None = None
    model: str = "division"
    pixel_aspect: float | None = None
    lines: Lines | None = None

    def __post_init__(self) -> None:
        _check_whole("--samples", self.samples, 3, MOST_SAMPLES)
        _check_whole("--sobel", self.sobel, 3, 31, odd=True)
        if not isinstance(self.refine, bool):
            raise UsageError(f"refine {self.refine!r}: True or False is needed")
        if self.model not in MODELS:
            raise UsageError(f"--model {self.model}: one of {', '.join(MODELS)} is needed")
        if self.model == "division2" and not self.refine:
            raise UsageError(
                "--no-refine: a search alone tells one parameter; --model division2 needs the refinement"
            )
        _check_center(self.center)
        least, most = PIXEL_ASPECTS
        if not (_is_number(self.aspect) and least <= self.aspect <= most):
            raise UsageError(
                f"--pixel-aspect {self.pixel_aspect}: a ratio from {least:g} to {most:g} is needed"
            )
        if not (_is_number(self.epsilon) and 0 < self.epsilon < math.inf):
            raise UsageError(f"epsilon {self.epsilon}: a range above 0 is needed, in px^-2")
        _check_whole("max_rounds", self.max_rounds, 1, MOST_ROUNDS)
        if not (_is_number(self.center_region) and 0 <= self.center_region <= 1):
            raise UsageError(
                f"center_region {self.center_region}: a share of the picture is needed, 0 to 1"
            )
        if self.roi is not None:
            _check_roi(self.roi)
        if self.lines is not None:
            if self.method not in METHODS_OF_LINES:
                raise UsageError(f"--lines goes with --method {' or '.join(METHODS_OF_LINES)}")
            check_lines(self.lines)

    @property
    def aspect(self) -> float:
        """A pixel's width over its height: 1 where nobody says."""
        return 1.0 if self.pixel_aspect is None else self.pixel_aspect


def check_lines(lines: Lines) -> None:
    """Refuse what are no lines, and those that could only be straight.

    The latter have fewer than 3 different points, or no length.
    """
    if not _are_lines(lines):
        raise UsageError("--lines: lines are needed, each of points (x, y), two numbers in px")
    if not lines or min(len(line) for line in lines) < 3:
        raise UsageError("--lines: at least one line is needed, of 3 points or more each")
    for number, line in enumerate(lines, 1):
        if len(set(line)) < 3:
            raise UsageError(f"--lines: line {number} has fewer than 3 different points")
        if max(max(axis) - min(axis) for axis in zip(*line, strict=True)) < SHORTEST_LINE:
            raise UsageError(
                f"--lines: line {number} has no length: {SHORTEST_LINE:g} px is the least"
            )


def _is_number(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)


def _are_lines(lines: object) -> bool:
    return isinstance(lines, tuple | list) and all(
        isinstance(line, tuple | list) and all(_is_point(point) for point in line) for line in lines
    )


def _is_point(point: object) -> bool:
    return (
        isinstance(point, tuple)
        and len(point) == 2
        and all(_is_number(v) and math.isfinite(v) for v in point)
    )


def _check_whole(name: str, value: int, least: int, most: int, odd: bool = False) -> None:
    whole = isinstance(value, Integral) and not isinstance(value, bool)
    if not whole or not least <= value <= most or (odd and value % 2 == 0):
        kind = "an odd number" if odd else "a whole number"
        raise UsageError(f"{name} {value}: {kind} from {least} to {most} is needed")


def _check_center(center: Center) -> None:
    if isinstance(center, str):
        if center not in ("free", "image"):
            raise UsageError(f"--center {center}: free, image or X,Y is needed")
    elif not _is_point(center):
        raise UsageError(f"--center {center}: free, image or two numbers (x, y) in px are needed")


def _check_roi(roi: tuple[int, ...]) -> None:
    whole = isinstance(roi, tuple) and len(roi) == 4 and all(isinstance(v, Integral) for v in roi)
    if not whole or min(roi[2:]) < 1 or min(roi[:2]) < 0:
        raise UsageError(
            "--roi: whole X,Y from 0 and a width and height of at least 1 px are needed"
        )
