"""How well the visible circle is found on frames with known truth, and how often where there is none."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ..boundary.detect import find_boundary
from .plain_frames import random_plain_frame
from .rim_frames import random_rim_frame


@dataclass(frozen=True)
class RimScore:
    """Errors over the frames with one trouble, px of the height: median and 95th percentile.

    A frame where nothing was found counts as infinitely wrong; ``missed`` is how many. ``worst`` is the
    worst frame's seed, and ``worst_error`` the larger of its two errors.
    """

    trouble: str
    frames: int
    missed: int
    diameter: tuple[float, float]
    center: tuple[float, float]
    worst: int
    worst_error: float

    def data(self) -> dict[str, Any]:
        """Return it as plain data, None for infinite."""
        return {k: _finite(v) for k, v in asdict(self).items()}


def score_rims(trouble: str, seeds: Iterable[int]) -> RimScore:
    """Find the circle in random frames with one of TROUBLES."""
    numbers = list(seeds)
    errors = np.array([_errors(seed, trouble) for seed in numbers])
    worst = int(errors.max(axis=1).argmax())
    diameter, center = (tuple(_percentiles(errors[:, i])) for i in (0, 1))
    return RimScore(
        trouble,
        len(numbers),
        int(np.isinf(errors[:, 0]).sum()),
        (diameter[0], diameter[1]),
        (center[0], center[1]),
        numbers[worst],
        float(errors[worst].max()),
    )


@dataclass(frozen=True)
class PlainScore:
    """How many of ``frames`` without a circle one was found in, and their seeds and kinds."""

    frames: int
    false: tuple[tuple[int, str], ...]


def score_plain(seeds: Iterable[int]) -> PlainScore:
    """Look for a circle where there is none."""
    false, frames = [], 0
    for seed in seeds:
        image, kind = random_plain_frame(seed)
        frames += 1
        if find_boundary(image) is not None:
            false.append((seed, kind))
    return PlainScore(frames, tuple(false))


def _errors(seed: int, trouble: str) -> tuple[float, float]:
    frame = random_rim_frame(seed, trouble)
    found = find_boundary(frame.image, frame.pixel_aspect)
    if found is None:
        return math.inf, math.inf
    dx = (found.center[0] - frame.center[0]) * frame.pixel_aspect
    dy = found.center[1] - frame.center[1]
    return abs(found.diameter - frame.diameter), math.hypot(dx, dy)


def _percentiles(values: np.ndarray) -> list[float]:
    """Median and 95th percentile, each an actual value, so that infinities stay what they are."""
    return [float(np.percentile(values, q, method="inverted_cdf")) for q in (50, 95)]


def _finite(value: Any) -> Any:
    if isinstance(value, tuple):
        return [_finite(v) for v in value]
    return None if isinstance(value, float) and math.isinf(value) else value
