"""A blurred step fitted to grey levels across an edge: its place, and which side is bright.

The least-squares fit of a step of known width is what white noise moves least (the matched filter); the
steepest place of a picture smoothed by less than twice the edge's own blur is moved up to twice as far.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from .straightness import Floats

# Widths (standard deviations of the blur) that are tried, px; a step is looked at so many widths to both
# sides, and between these px: its place is told the better, the better the levels beside it are known.
WIDTHS = np.arange(0.7, 4.0, 0.1)
WINDOW, NARROWEST, WIDEST = 3.0, 3, 8
# The width is told from the middle of the mean profile: at its ends, other edges come in.
WIDTH_WINDOW = 4
# Steps are sought up to so far from the middle, px, on templates so far apart.
FARTHEST, SPACING = 1.5, 0.1
SHIFTS = np.arange(-FARTHEST, FARTHEST + SPACING / 2, SPACING)
ROUNDS = 3
# A mean profile that falls by this share of its height within a px has come to the next edge.
FALL = 0.02
# The width is that of steps within so many px of the middle.
MIDDLE = 0.25


@dataclass(frozen=True)
class Steps:
    """Steps fitted to profiles: offsets (n,) px from their middles; heights (n,), positive for rising ones.

    ``near`` (n,): which lie no farther from the middle than steps are sought; ``reach`` px: how far to both
    sides the levels were looked at.
    """

    offsets: Floats
    heights: Floats
    near: NDArray[np.bool_]
    reach: int


def fit_steps(profiles: Floats) -> Steps:
    """Fit a step to each of ``profiles`` (n, 2 * WIDEST + 1), grey levels 1 px apart, all of one width."""
    mean = _mean(profiles)
    steps = _fit(profiles, _width(mean), _free(mean))
    # The mean of profiles whose steps lie here and there is wider than each of them.
    middle = np.abs(steps.offsets) < MIDDLE
    if not middle.any():
        return steps
    mean = _mean(profiles[middle])
    return _fit(profiles, _width(mean), _free(mean))


def _fit(profiles: Floats, width: float, free: int) -> Steps:
    reach = int(np.clip(round(WINDOW * width), NARROWEST, free))
    y = profiles[:, WIDEST - reach : WIDEST + reach + 1]
    y = y - y.mean(axis=1, keepdims=True)
    rise, slope = _templates(reach, width)
    rr, ss, rs = (
        np.einsum("ij,ij->i", a, b) for a, b in ((rise, rise), (slope, slope), (rise, slope))
    )
    determinant = rr * ss - rs * rs
    k = np.full(len(y), len(SHIFTS) // 2)
    for _ in range(ROUNDS):
        ry, sy = np.einsum("ij,ij->i", rise[k], y), np.einsum("ij,ij->i", slope[k], y)
        height = (ss[k] * ry - rs[k] * sy) / determinant[k]
        moved = (rs[k] * ry - rr[k] * sy) / determinant[k]
        offset = SHIFTS[k] + moved / np.where(np.abs(height) < 1e-6, 1e-6, height)
        k = np.rint((np.clip(offset, -FARTHEST, FARTHEST) + FARTHEST) / SPACING).astype(np.intp)
    return Steps(offset, height, np.abs(offset) < FARTHEST, reach)


def _templates(reach: int, width: float) -> tuple[Floats, Floats]:
    """Steps of height 1 at each of SHIFTS, and their slopes, (k, 2 * reach + 1), less their means."""
    x = (np.arange(-reach, reach + 1) - SHIFTS[:, None]) / width
    rise, slope = ndtr(x), np.exp(-0.5 * x * x) / (np.sqrt(2 * np.pi) * width)
    return rise - rise.mean(axis=1, keepdims=True), slope - slope.mean(axis=1, keepdims=True)


def _mean(profiles: Floats) -> Floats:
    """The mean profile, falling ones turned round, less its mean."""
    sides = profiles[:, WIDEST + 1 :] - profiles[:, WIDEST - 1 :: -1]
    mean = np.sign(sides[:, :NARROWEST].sum(axis=1)) @ profiles
    return np.asarray(mean - mean.mean())


def _width(mean: Floats) -> float:
    """The width at which a step fits the middle of a mean profile best."""
    part = mean[WIDEST - WIDTH_WINDOW : WIDEST + WIDTH_WINDOW + 1]
    steps = ndtr(np.arange(-WIDTH_WINDOW, WIDTH_WINDOW + 1) / WIDTHS[:, None])
    steps -= steps.mean(axis=1, keepdims=True)
    explained = (steps @ part) ** 2 / (steps * steps).sum(axis=1)
    return float(WIDTHS[np.argmax(explained)])


def _free(mean: Floats) -> int:
    """How far from the middle, px, a mean profile rises or stays level: beyond, the next edges come in."""
    steps = np.diff(mean)
    falls = -FALL * np.ptp(mean) > np.minimum(steps[WIDEST:], steps[WIDEST - 1 :: -1])
    return max(int(np.argmax(falls)) if falls.any() else WIDEST, NARROWEST)
