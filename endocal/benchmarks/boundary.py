"""How fast the visible circle is found, beside the article's way of doing it in the same run."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from statistics import median
from typing import Any

import cv2
import numpy as np

from ..boundary.circle import Boundary
from ..boundary.detect import find_boundary
from .rim_frames import RimFrame, random_rim_frame

SIZES = ((720, 540), (1920, 1080))
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
# The article's contour is traced on a frame thinned to about this height.
_THINNED = 135


@dataclass(frozen=True)
class Row:
    """Frames per second at one size, of one processor; each is the median over the rounds, and the best.

    ``cold`` finds the circle in each frame anew, ``warm`` with the circle of the frame before at hand, as
    in a video. ``contour`` is threshold, outermost contour and least-squares circle on a thinned frame: the
    article's way, to a few px and without a check.
    """

    size: tuple[int, int]
    cold: float
    cold_best: float
    warm: float
    warm_best: float
    contour: float
    contour_best: float


@dataclass(frozen=True)
class Report:
    """One row per frame size, and how far the contour's circle and ours lie from the truth, px (median)."""

    rows: tuple[Row, ...]
    error: float
    contour_error: float

    def data(self) -> dict[str, Any]:
        """Return it as plain data."""
        return asdict(self)


def run(sizes: Sequence[tuple[int, int]] = SIZES, rounds: int = _ROUNDS) -> Report:
    """Time the detection on one core, over frames with all that commonly happens at the rim.

    The times are of this thread's processor, so that other work on the machine moves them less.
    """
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        rows, errors, contour_errors = [], [], []
        for size in sizes:
            frames = [
                random_rim_frame(i, _TROUBLES[i % len(_TROUBLES)], size) for i in range(_FRAMES)
            ]
            found = [find_boundary(f.image) for f in frames]
            errors += [_error(b, f) for b, f in zip(found, frames, strict=True)]
            contour_errors += [_error(contour_circle(f.image), f) for f in frames]
            cold = _rates(lambda f, b: find_boundary(f.image), frames, found, rounds)
            warm = _rates(lambda f, b: find_boundary(f.image, guess=b), frames, found, rounds)
            contour = _rates(lambda f, b: contour_circle(f.image), frames, found, rounds)
            rows.append(Row(size, *cold, *warm, *contour))
    finally:
        cv2.setNumThreads(threads)
    return Report(tuple(rows), median(errors), median(contour_errors))


def contour_circle(image: np.ndarray) -> Boundary | None:
    """Find the circle as the article says: threshold, outermost contour, circle by least squares."""
    step = max(1, round(min(image.shape) / _THINNED))
    thinned = np.ascontiguousarray(image[::step, ::step])
    _, lit = cv2.threshold(thinned, 24, 255, cv2.THRESH_BINARY)
    contours, _ = cv2.findContours(lit, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not contours:
        return None
    points = max(contours, key=len)[:, 0].astype(np.float64)
    h, w = thinned.shape
    x, y = points[:, 0], points[:, 1]
    inner = (x > 0) & (x < w - 1) & (y > 0) & (y < h - 1)
    if np.count_nonzero(inner) < 3:
        return None
    x, y = x[inner], y[inner]
    rows = np.stack([x, y, np.ones_like(x)], axis=1)
    a, b, c = np.linalg.lstsq(rows, x * x + y * y, rcond=None)[0]
    radius = float(np.sqrt(max(c + a * a / 4 + b * b / 4, 0.0)))
    area = float(np.count_nonzero(lit)) * step * step
    return Boundary((a / 2 * step, b / 2 * step), 2 * radius * step, area, 1.0)


def _rates(
    work: Callable[[RimFrame, Boundary | None], Any],
    frames: Sequence[RimFrame],
    found: Sequence[Boundary | None],
    rounds: int,
) -> tuple[float, float]:
    """Return frames per second of processor time: the median over the rounds, and the best."""
    rates = []
    for _ in range(rounds + 1):
        began = time.thread_time()
        for frame, boundary in zip(frames, found, strict=True):
            work(frame, boundary)
        rates.append(len(frames) / (time.thread_time() - began))
    # The first round fills caches.
    return median(rates[1:]), max(rates[1:])


def _error(found: Boundary | None, truth: RimFrame) -> float:
    """The larger of the diameter's and the centre's error, px; infinite where nothing was found."""
    if found is None:
        return float("inf")
    apart = np.hypot(found.center[0] - truth.center[0], found.center[1] - truth.center[1])
    return float(max(abs(found.diameter - truth.diameter), apart))
