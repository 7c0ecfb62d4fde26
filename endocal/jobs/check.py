"""Calibrate again from the recorded pictures and compare: the job behind ``endocal check``."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

from ..calibration.recorded import spec_of
from ..calibration.result import Calibration, Uncertainty
from ..errors import InputError, UsageError
from ..files import dumps, load, loads
from ..files.names import shown
from .calibrate import calibrate_files
from .recorded_pictures import find_picture

TOLERANCE = 0.1
# Standard deviations that stand in where none are stated: of lambdas as a share of themselves, and of the
# centre in px. A search without refinement repeats itself far better than that.
UNSTATED_SHARE = 0.01
UNSTATED_CENTER = 1.0


@dataclass(frozen=True)
class CheckSpec:
    """What to check.

    ``file`` is a calibration; its pictures are looked for beside it, or anywhere below ``images``.
    ``tolerance`` is how far a number may move, in its standard deviations: the smaller of the one that is
    recorded and the one that is found now.
    """

    file: str
    images: str | None = None
    tolerance: float = TOLERANCE

    def __post_init__(self) -> None:
        if not 0 <= self.tolerance < float("inf"):
            raise UsageError(f"--tolerance {self.tolerance:g}: 0 or more is needed")


@dataclass(frozen=True)
class Number:
    """A number of the model: as recorded, as found now, and how far apart the two may be, in ``unit``."""

    name: str
    unit: str
    recorded: float
    found: float
    allowed: float

    @property
    def moved(self) -> float:
        """How far it moved."""
        return abs(self.found - self.recorded)

    @property
    def passed(self) -> bool:
        """Whether it moved no farther than it may."""
        return self.moved <= self.allowed

    def __str__(self) -> str:
        return (
            f"{self.name} moved by {self.moved:.2g} {self.unit}, where {self.allowed:.2g} is allowed:"
            f" {self.recorded:.9g} recorded, {self.found:.9g} found"
        )


@dataclass(frozen=True)
class CheckReport:
    """The numbers, the verdicts (None: none recorded), and the paths of the pictures."""

    file: str
    tolerance: float
    numbers: tuple[Number, ...]
    recorded_verdict: str | None
    found_verdict: str | None
    pictures: tuple[str, ...]

    @property
    def failures(self) -> tuple[str, ...]:
        """What makes the check fail, in words: each number that moved too far, a verdict of failed."""
        moved = [str(number) for number in self.numbers if not number.passed]
        if self.found_verdict == "failed" != self.recorded_verdict:
            moved.append("the verdict is failed now")
        return tuple(moved)

    def data(self) -> dict[str, Any]:
        """Return the report as plain data."""
        numbers = [{**asdict(n), "moved": n.moved, "passed": n.passed} for n in self.numbers]
        return {**asdict(self), "numbers": numbers, "passed": not self.failures}


def check(spec: CheckSpec) -> CheckReport:
    """Calibrate again from the pictures that a calibration names, with its own options, and compare.

    Raises InputError for a file that is no calibration or names no pictures, for a picture that is not
    found or is another one by its SHA-256; CalibrationError where no line is found in them now.
    """
    recorded = load(spec.file)
    name = "<stdin>" if spec.file == "-" else shown(spec.file)
    if not isinstance(recorded, Calibration):
        raise InputError(f"{name}: is a zoom table; check the calibrations that it was made of")
    images = recorded.source.images if recorded.source else ()
    if not images:
        raise InputError(f"{name}: names no picture that it was made from; calibrate anew")
    pictures = tuple(find_picture(image, spec.file, spec.images) for image in images)
    try:
        again = calibrate_files(pictures, spec_of(recorded))
    except UsageError as error:
        raise InputError(f"{name}: [source] {error}") from None
    # As it would be written: numbers are rounded well below their uncertainty.
    found = loads(dumps(again))
    assert isinstance(found, Calibration)
    if found.model.size != recorded.model.size:
        raise InputError(
            f"{name}: [model] size is {_size(recorded)}, but its pictures are {_size(found)}"
        )
    return CheckReport(
        file=spec.file,
        tolerance=spec.tolerance,
        numbers=tuple(compared(recorded, found, spec.tolerance)),
        recorded_verdict=recorded.quality.verdict if recorded.quality else None,
        found_verdict=found.quality.verdict if found.quality else None,
        pictures=pictures,
    )


def compared(recorded: Calibration, found: Calibration, tolerance: float) -> Iterator[Number]:
    """Yield the numbers of two calibrations; ``tolerance`` in standard deviations, see CheckSpec."""
    a, b = recorded.model, found.model
    sigma = _sigmas(recorded, found)
    yield Number("lambda", "px^-2", a.lam, b.lam, tolerance * sigma.lam)
    if a.lam2 or b.lam2:
        assert sigma.lam2 is not None
        yield Number("lambda2", "px^-4", a.lam2, b.lam2, tolerance * sigma.lam2)
    for i, axis in enumerate("xy"):
        allowed = tolerance * sigma.center[i]
        yield Number(f"center {axis}", "px", a.center[i], b.center[i], allowed)


def _sigmas(recorded: Calibration, found: Calibration) -> Uncertainty:
    """The smaller standard deviation of each number, with what stands in for one that is not stated.

    By the recorded ones alone, a file could say of itself that any change is a small one.
    """
    model = recorded.model
    unstated = Uncertainty(
        UNSTATED_SHARE * abs(model.lam),
        (UNSTATED_CENTER, UNSTATED_CENTER),
        UNSTATED_SHARE * abs(model.lam2),
    )
    if recorded.uncertainty is None:
        return unstated
    both = [recorded.uncertainty, found.uncertainty or unstated]
    x, y = (min(u.center[i] for u in both) for i in (0, 1))
    lam2 = min((unstated if u.lam2 is None else u).lam2 or 0.0 for u in both)
    return Uncertainty(min(u.lam for u in both), (x, y), lam2)


def _size(calibration: Calibration) -> str:
    return "x".join(str(n) for n in calibration.model.size)
