"""How fast the visible circle is found, beside the article's way of doing it in the same run."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import cv2
import numpy as np

from ..boundary.circle import Boundary
from ..boundary.detect import find_boundary
from .rim_frames import RimFrame, random_rim_frame

SIZES = ((720, 540), (1920, 1080))
Way = Callable[[RimFrame, Boundary | None], Any]
# The article's figure, at 720x540 on one core of its machine (section IV-B).
ARTICLE_RATE, ARTICLE_SIZE = 535, (720, 540)
# What happens at the rim, in the mix that is timed; each frame is another picture.
_TROUBLES = (
    "plain",
    "noise",
    "instruments",
    "smoke",
    "logos",
    "raised black",
    "cut 2 sides",
    "notch",
)
_FRAMES = 32
_ROUNDS = 12
# The article's contour is traced on a frame thinned to about this height, where it is brighter than this.
_THINNED, _LIT = 135, 24
# The prototype looks for the rim along so many radii, so far to either side of the contour's circle, px.
_ANGLE = np.arange(112) * (2 * np.pi / 112)
_COSINE, _SINE, _RADII = np.cos(_ANGLE), np.sin(_ANGLE), np.arange(-10.0, 11.0)


@dataclass(frozen=True)
class Row:
    """Frames per second at one size, of one processor; each is the median over the rounds, and the best.

    ``warm`` finds the circle with that of the frame before at hand, as in a video, ``cold`` in each frame
    anew. ``contour`` is threshold, outermost contour and least-squares circle on a thinned frame: the
    article's way, to a few px and without a check. ``prototype`` goes on from there to the rim at full size,
    and bears none of what happens at a rim.
    """

    size: tuple[int, int]
    warm: float
    warm_best: float
    cold: float
    cold_best: float
    contour: float
    contour_best: float
    prototype: float
    prototype_best: float


@dataclass(frozen=True)
class Report:
    """One row per frame size, and how far each way's circle lies from the truth, px: median and 95 %."""

    rows: tuple[Row, ...]
    error: tuple[float, float]
    contour_error: tuple[float, float]
    prototype_error: tuple[float, float]

    def data(self) -> dict[str, Any]:
        """Return it as plain data; None where no circle was found, the error infinite."""
        data = asdict(self)
        for name in ("error", "contour_error", "prototype_error"):
            data[name] = [e if np.isfinite(e) else None for e in data[name]]
        return data


def run(sizes: Sequence[tuple[int, int]] = SIZES, rounds: int = _ROUNDS) -> Report:
    """Time the detection on one core, over frames with all that commonly happens at the rim.

    The times are of this thread's processor, so that other work on the machine moves them less.
    """
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        rows, errors = [], np.empty((3, 0))
        for size in sizes:
            frames = [
                random_rim_frame(i, _TROUBLES[i % len(_TROUBLES)], size) for i in range(_FRAMES)
            ]
            found = [find_boundary(f.image) for f in frames]
            others = [[way(f.image) for f in frames] for way in (contour_circle, prototype_circle)]
            new = [[_error(b, f) for b, f in zip(w, frames, strict=True)] for w in (found, *others)]
            errors = np.concatenate([errors, new], axis=1)
            ways: tuple[Way, ...] = (
                lambda f, b: find_boundary(f.image, guess=b),
                lambda f, b: find_boundary(f.image),
                lambda f, b: contour_circle(f.image),
                lambda f, b: prototype_circle(f.image),
            )
            rates = _rates(ways, frames, found, rounds)
            rows.append(Row(size, *(rate for pair in rates for rate in pair)))
    finally:
        cv2.setNumThreads(threads)
    return Report(tuple(rows), *(_spread(e) for e in errors))


def contour_circle(image: np.ndarray) -> Boundary | None:
    """Find the circle as the article says: threshold, outermost contour, circle by least squares."""
    step = max(1, round(min(image.shape) / _THINNED))
    thinned = np.ascontiguousarray(image[::step, ::step])
    _, lit = cv2.threshold(thinned, _LIT, 255, cv2.THRESH_BINARY)
    contours, _ = cv2.findContours(lit, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not contours:
        return None
    points = max(contours, key=len)[:, 0].astype(np.float64)
    h, w = thinned.shape
    x, y = points[:, 0], points[:, 1]
    inner = (x > 0) & (x < w - 1) & (y > 0) & (y < h - 1)
    if np.count_nonzero(inner) < 3:
        return None
    cx, cy, radius = (step * v for v in _least_squares_circle(x[inner], y[inner]))
    return Boundary((cx, cy), 2 * radius, float(np.count_nonzero(lit)) * step * step, 1.0)


def prototype_circle(image: np.ndarray) -> Boundary | None:
    """Find that circle, and then measure its rim at full size to a fraction of a pixel, without a check."""
    rough = contour_circle(image)
    if rough is None:
        return None
    (cx, cy), radius = rough.center, rough.diameter / 2 + _RADII
    x, y = cx + np.multiply.outer(_COSINE, radius), cy + np.multiply.outer(_SINE, radius)
    profile = cv2.remap(image, x.astype(np.float32), y.astype(np.float32), cv2.INTER_LINEAR)
    falls = profile[:, :-2].astype(np.float32) - profile[:, 2:]
    at = np.clip(falls.argmax(axis=1), 1, falls.shape[1] - 2)
    row = np.arange(len(at))
    before, middle, after = falls[row, at - 1], falls[row, at], falls[row, at + 1]
    bend = np.maximum(2 * middle - before - after, 1e-3)
    rim = rough.diameter / 2 + _RADII[at + 1] + (after - before) / (2 * bend)
    x, y = cx + rim * _COSINE, cy + rim * _SINE
    h, w = image.shape
    use = (middle > _LIT) & (x > 1) & (x < w - 2) & (y > 1) & (y < h - 2)
    if np.count_nonzero(use) < 3:
        return rough
    cx, cy, fitted = _least_squares_circle(x[use], y[use])
    return Boundary((cx, cy), 2 * fitted, rough.area, 1.0)


def _least_squares_circle(x: np.ndarray, y: np.ndarray) -> tuple[float, float, float]:
    rows = np.stack([x, y, np.ones_like(x)], axis=1)
    a, b, c = np.linalg.lstsq(rows, x * x + y * y, rcond=None)[0]
    return a / 2, b / 2, float(np.sqrt(max(c + a * a / 4 + b * b / 4, 0.0)))


def _rates(
    ways: Sequence[Way],
    frames: Sequence[RimFrame],
    found: Sequence[Boundary | None],
    rounds: int,
) -> list[tuple[float, float]]:
    """Return each way's frames per second of processor time: the median over the rounds, and the best.

    The ways take turns, so that what else the machine does meets all of them alike.
    """
    spent = np.zeros((rounds + 1, len(ways)))
    for times in spent:
        for i, way in enumerate(ways):
            began = time.thread_time()
            for frame, boundary in zip(frames, found, strict=True):
                way(frame, boundary)
            times[i] = time.thread_time() - began
    # The first round fills caches.
    rates = len(frames) / spent[1:]
    return [(float(np.median(r)), float(r.max())) for r in rates.T]


def _spread(errors: np.ndarray) -> tuple[float, float]:
    """Median and 95th percentile, each an actual value, so that infinities stay what they are."""
    median, most = np.percentile(errors, (50, 95), method="inverted_cdf").tolist()
    return median, most


def _error(found: Boundary | None, truth: RimFrame) -> float:
    """The larger of the diameter's and the centre's error, px; infinite where nothing was found."""
    if found is None:
        return float("inf")
    apart = np.hypot(found.center[0] - truth.center[0], found.center[1] - truth.center[1])
    return float(max(abs(found.diameter - truth.diameter), apart))
