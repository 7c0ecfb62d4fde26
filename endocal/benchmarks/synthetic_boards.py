"""What calibration makes of random boards, of ``endocal.synth.random``, whose distortion is known."""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from multiprocessing import get_context
from typing import Any, TypeVar

import cv2
import numpy as np

from ..boundary.circle import Boundary
from ..boundary.content import content_radius
from ..calibration.calibrate import calibrate
from ..calibration.fit.plumb_line import robust_sigma
from ..calibration.result import Calibration
from ..calibration.scene import Image
from ..calibration.spec import CalibrationSpec
from ..errors import CalibrationError
from ..synth.board import BoardScene, render_board
from ..synth.random import random_board

T = TypeVar("T")

# A model that is off by more than this and called good is wrong in silence.
SILENT_ERROR = 0.02
# Nothing was found, with an error that says why; or with one that does not, which is a fault of ours.
REFUSED, CRASHED = "refused", "crashed"


@dataclass(frozen=True)
class Outcome:
    """What was made of one board.

    ``strength`` is lam R^2 of the scene, R being its farthest visible pixel's radius. ``lam_error`` is
    |found - true| / |true| and ``center_error`` px; both infinite where nothing was found. ``z`` are the
    errors of lam, cx and cy over their stated standard deviations.
    """

    seed: int
    size: tuple[int, int]
    pattern: str
    strength: float
    verdict: str
    reasons: tuple[str, ...]
    lam_error: float
    center_error: float
    z: tuple[float, float, float] | None
    seconds: float

    @property
    def silent(self) -> bool:
        """Whether it is wrong and says that it is good."""
        return self.verdict == "good" and self.lam_error > SILENT_ERROR

    def data(self) -> dict[str, Any]:
        """Return the outcome as plain data; what is infinite as None."""
        return {k: _finite(v) for k, v in asdict(self).items()}


@dataclass(frozen=True)
class Summary:
    """The table's row for a set of boards: shares of one and px; ``z`` the robust spreads of the z-scores."""

    boards: int
    verdicts: dict[str, int]
    lam_median: float
    lam_p95: float
    center_median: float
    center_p95: float
    z: tuple[float, float, float] | None
    silent: tuple[int, ...]  # seeds
    seconds: float  # median

    def data(self) -> dict[str, Any]:
        """Return the summary as plain data; what is infinite as None."""
        return {k: _finite(v) for k, v in asdict(self).items()}


def run(
    seeds: Iterable[int], processes: int = 1, progress: Callable[[Outcome], None] = lambda o: None
) -> tuple[Outcome, ...]:
    """Render and calibrate the boards of these seeds, in order; ``progress`` gets each as it is done."""
    outcomes = []
    for outcome in each(run_board, list(seeds), processes):
        progress(outcome)
        outcomes.append(outcome)
    return tuple(outcomes)


def run_board(seed: int) -> Outcome:
    """Render board number ``seed``, calibrate from the picture alone, and compare with its truth."""
    scene = random_board(seed)
    picture = render_board(scene)
    start = time.perf_counter()
    found, verdict, reasons = attempt(picture, CalibrationSpec())
    seconds = time.perf_counter() - start
    lam_error, center_error, z = _errors(scene, found)
    return Outcome(
        seed=seed,
        size=scene.model.size,
        pattern=scene.pattern.kind,
        strength=strength_of(scene),
        verdict=verdict,
        reasons=reasons,
        lam_error=lam_error,
        center_error=center_error,
        z=z,
        seconds=seconds,
    )


def attempt(
    picture: Image, spec: CalibrationSpec
) -> tuple[Calibration | None, str, tuple[str, ...]]:
    """Calibrate; return the calibration or None, the verdict or REFUSED or CRASHED, and the reasons."""
    try:
        found = calibrate(picture, spec)
    except CalibrationError as error:
        return None, REFUSED, (str(error),)
    except Exception as error:
        # A benchmark counts a crash; it does not die of it.
        return None, CRASHED, (f"{type(error).__name__}: {error}",)
    assert found.quality is not None, "a calibration from pictures has a verdict"
    return found, found.quality.verdict, found.quality.reasons


def summarise(outcomes: Sequence[Outcome]) -> Summary:
    """Return the row of a set of one board or more; nothing found counts as infinitely wrong."""
    lam = np.array([o.lam_error for o in outcomes])
    center = np.array([o.center_error for o in outcomes])
    scores = np.array([o.z for o in outcomes if o.z is not None])
    return Summary(
        boards=len(outcomes),
        verdicts=dict(Counter(o.verdict for o in outcomes)),
        lam_median=_quantile(lam, 0.5),
        lam_p95=_quantile(lam, 0.95),
        center_median=_quantile(center, 0.5),
        center_p95=_quantile(center, 0.95),
        z=_three([robust_sigma(column) for column in scores.T]) if len(scores) else None,
        silent=tuple(o.seed for o in outcomes if o.silent),
        seconds=float(np.median([o.seconds for o in outcomes])),
    )


def worst(outcomes: Sequence[Outcome], count: int) -> list[Outcome]:
    """Return the boards of the ``count`` largest errors of lam, the worst first, then of the centre."""
    by_lam = sorted(outcomes, key=lambda o: -o.lam_error)[:count]
    by_center = sorted(outcomes, key=lambda o: -o.center_error)[:count]
    return by_lam + [o for o in by_center if o not in by_lam]


def each(board: Callable[[int], T], seeds: Sequence[int], processes: int) -> Iterator[T]:
    """Yield what ``board`` makes of each seed, in order, worked out in so many processes."""
    if processes == 1:
        yield from map(board, seeds)
        return
    with ProcessPoolExecutor(processes, get_context("spawn"), _one_thread_each) as pool:
        yield from pool.map(board, seeds)


def _one_thread_each() -> None:
    """Several processes fill the processors already."""
    cv2.setNumThreads(1)


def _errors(
    scene: BoardScene, found: Calibration | None
) -> tuple[float, float, tuple[float, float, float] | None]:
    if found is None:
        return math.inf, math.inf, None
    true, model, sigma = scene.division, found.model, found.uncertainty
    errors = (
        model.lam - true.lam,
        model.center[0] - true.center[0],
        model.center[1] - true.center[1],
    )
    lam_error, center_error = abs(errors[0] / true.lam), math.hypot(*errors[1:])
    if sigma is None or min(sigma.lam, *sigma.center) <= 0:
        return lam_error, center_error, None
    sigmas = (sigma.lam, *sigma.center)
    return lam_error, center_error, _three([e / s for e, s in zip(errors, sigmas, strict=True)])


def strength_of(scene: BoardScene) -> float:
    """Return lam R^2, R being the radius of the farthest visible pixel."""
    model, circle = scene.division, scene.circle
    boundary = Boundary(circle.center, circle.diameter, 0.0, 1.0) if circle else None
    return model.lam * content_radius(model.center, model.size, boundary, model.pixel_aspect) ** 2


def _quantile(values: Any, share: float) -> float:
    """The quantile, not interpolated: an infinite neighbour would make it NaN."""
    return float(np.quantile(values, share, method="higher"))


def _three(values: Sequence[float]) -> tuple[float, float, float]:
    a, b, c = (float(v) for v in values)
    return a, b, c


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value
