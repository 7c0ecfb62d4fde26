"""A blurred step fitted to grey levels across an edge: its place, and which side is bright.

The least-squares fit of a step of known width is what white noise moves least (the matched filter); the
steepest place of a picture smoothed by less than twice the edge's own blur is moved up to twice as far.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from ..straightness import Floats, Labels

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
# The mean profile of a stretch of so many px that falls by this share of its height within a px has come to
# the next edge.
STRETCH, FALL = 48, 0.03
# The width is that of steps within so many px of the middle.
MIDDLE = 0.25


@dataclass(frozen=True)
class Steps:
    """Steps fitted to profiles: offsets (n,) px from their middles; heights (n,), positive for rising ones.

    ``near`` (n,): which lie no farther from the middle than steps are sought; ``reach`` (n,) px: how far to
    both sides the levels were looked at.
    """

    offsets: Floats
    heights: Floats
    near: NDArray[np.bool_]
    reach: Labels


def fit_steps(profiles: Floats, owner: Labels) -> Steps:
    """Fit a step to each of ``profiles`` (n, 2 * WIDEST + 1), grey levels 1 px apart, all of one width.

    Those of one ``owner`` (n,) follow each other along a line.
    """
    rising = _rising(profiles)
    free = _free(rising, owner)
    steps = _fit(profiles, _width(rising.sum(axis=0)), free)
    # The mean of profiles whose steps lie here and there is wider than each of them.
    middle = np.abs(steps.offsets) < MIDDLE
    return _fit(profiles, _width(rising[middle].sum(axis=0)), free) if middle.any() else steps


def _fit(profiles: Floats, width: float, free: Labels) -> Steps:
    wanted = int(np.clip(round(WINDOW * width), NARROWEST, WIDEST))
    reach = np.minimum(free, wanted)
    offsets, heights = np.empty(len(profiles)), np.empty(len(profiles))
    for r in np.unique(reach):
        own = reach == r
        offsets[own], heights[own] = _fit_within(profiles[own], width, int(r))
    return Steps(offsets, heights, np.abs(offsets) < FARTHEST, reach)


def _fit_within(profiles: Floats, width: float, reach: int) -> tuple[Floats, Floats]:
    """Offsets and heights of steps, from levels up to ``reach`` px from the middle."""
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
    return offset, height


def _templates(reach: int, width: float) -> tuple[Floats, Floats]:
    """Steps of height 1 at each of SHIFTS, and their slopes, (k, 2 * reach + 1), less their means."""
    x = (np.arange(-reach, reach + 1) - SHIFTS[:, None]) / width
    rise, slope = ndtr(x), np.exp(-0.5 * x * x) / (np.sqrt(2 * np.pi) * width)
    return rise - rise.mean(axis=1, keepdims=True), slope - slope.mean(axis=1, keepdims=True)


def _rising(profiles: Floats) -> Floats:
    """The profiles less their means, falling ones turned round."""
    sides = profiles[:, WIDEST + 1 :] - profiles[:, WIDEST - 1 :: -1]
    rising = np.sign(sides[:, :NARROWEST].sum(axis=1))[:, None] * profiles
    return np.asarray(rising - rising.mean(axis=1, keepdims=True))


def _width(mean: Floats) -> float:
    """The width at which a step fits the middle of a mean profile best."""
    part = mean[WIDEST - WIDTH_WINDOW : WIDEST + WIDTH_WINDOW + 1]
    part = part - part.mean()
    steps = ndtr(np.arange(-WIDTH_WINDOW, WIDTH_WINDOW + 1) / WIDTHS[:, None])
    steps -= steps.mean(axis=1, keepdims=True)
    explained = (steps @ part) ** 2 / (steps * steps).sum(axis=1)
    return float(WIDTHS[np.argmax(explained)])


def _free(rising: Floats, owner: Labels) -> Labels:
    """How far from the middle, (n,) px, profiles rise or stay level: beyond, the next edges come in.

    That is told for a stretch of each line at a time: bars and squares are seen narrower here than there.
    """
    first = np.flatnonzero(np.diff(owner, prepend=-1) != 0)
    along = np.arange(len(owner)) - np.repeat(first, np.diff(first, append=len(owner)))
    starts = np.flatnonzero(along % STRETCH == 0)
    mean = np.add.reduceat(rising, starts) / np.diff(starts, append=len(owner))[:, None]
    steps = np.diff(mean, axis=1)
    outward = np.minimum(steps[:, WIDEST:], steps[:, WIDEST - 1 :: -1])
    falls = outward < -FALL * np.ptp(mean, axis=1)[:, None]
    free = np.where(falls.any(axis=1), falls.argmax(axis=1), WIDEST)
    return np.repeat(np.maximum(free, NARROWEST), np.diff(starts, append=len(owner)))
