"""Every tunable of a calibration, named, with unit and default."""

from __future__ import annotations

from dataclasses import dataclass

from ..errors import UsageError

MODELS = ("division", "division2")

# The methods that take lines which somebody chose.
METHODS_OF_LINES = ("wang", "htrdc")

Center = str | tuple[float, float]
# Each line as its points (x, y), px of the frame.
Lines = tuple[tuple[tuple[float, float], ...], ...]


@dataclass(frozen=True)
class CalibrationSpec:
    """How to calibrate.

    ``method`` is a name in the registry of methods; ``refine`` turns the plumb-line refinement on.
    ``center`` is "free" (searched), "image" (the frame's centre) or an (x, y) in px to keep.
    ``samples`` per axis of Algorithm 1 and ``epsilon``, the range of lambda in px^-2 at which it stops, are
    the article's. ``sobel`` is how many px around an edge point tell its direction, the
    article's size of a mask. ``roi`` is
    (x, y, width, height) in px: edges outside it are ignored. ``model`` is one of MODELS.
    ``pixel_aspect`` is a pixel's width over its height. ``lines`` are lines that somebody chose in the
    picture, for the methods that take some. Raises UsageError for values that make no sense.
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
    pixel_aspect: float = 1.0
    lines: Lines | None = None

    def __post_init__(self) -> None:
        if self.samples < 3:
            raise UsageError(f"--samples {self.samples}: at least 3 are needed to narrow a range")
        if self.sobel < 3 or self.sobel > 31 or self.sobel % 2 == 0:
            raise UsageError(f"--sobel {self.sobel}: an odd size from 3 to 31 is needed")
        if self.model not in MODELS:
            raise UsageError(f"--model {self.model}: one of {', '.join(MODELS)} is needed")
        if isinstance(self.center, str) and self.center not in ("free", "image"):
            raise UsageError(f"--center {self.center}: free, image or X,Y is needed")
        if self.pixel_aspect <= 0:
            raise UsageError(f"--pixel-aspect {self.pixel_aspect:g}: a positive number is needed")
        if self.roi is not None and (min(self.roi[2:]) < 1 or min(self.roi[:2]) < 0):
            raise UsageError("--roi: X,Y from 0 and a width and height of at least 1 px are needed")
        if self.lines is not None:
            if self.method not in METHODS_OF_LINES:
                raise UsageError(f"--lines goes with --method {' or '.join(METHODS_OF_LINES)}")
            if not self.lines or min(len(line) for line in self.lines) < 3:
                raise UsageError("--lines: at least one line is needed, of 3 points or more each")
