"""A rim without a step: the light fades to black towards it, and the circle is where it reaches black."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .departure import RimPoints
from .disc import Box
from .fit import Circle, fit_offsets
from .frame import Frame
from .outside import Dark
from .rim import DIRECTIONS, Rim, all_bearings, angles, directions, inside_box, profiles

Array = NDArray[np.float32]

# The profile, as fractions of the radius: from where the fade is clear to where the outside is.
_INNER, _OUTER, _SAMPLES = -0.16, 0.08, 49
# A fade is shallow, so that noise counts: each profile is the mean of so many side by side.
_BESIDE = 4
# The samples at the outer end that are surely outside.
_OUTSIDE = 5
# Where straight lines are fitted to the fade at first, and how much brighter the profile must be at its
# start than at its middle: a fade goes on inwards, a soft step does not.
_LINE = (-0.16, -0.03)
_GROWTH = 1.4
_ROUNDS = 4
# How much the scene's own brightness varies along a fade, relative: what bends the lines.
_TEXTURE = 0.15
# The crossings' scatter and the centre's standard deviation, of the radius, in what still is a circle.
_TOLERANCE, _CENTER_TOLERANCE = 0.02, 0.007
# A fade leaves black with a kink: so much of its brightness at the inner end is due to the slope there. With
# less it is a glow about the circle, which has no end; with more the shoulder of a step.
_KINK = (0.6, 1.5)
# Nor is there a step in it: half of the profiles fall by no more than this share of their brightness within
# so many samples, 2 % of the radius.
_FALL, _WITHIN = 0.45, 4
# A fade takes longer than a step, so that more of the visible rim has to show it.
_SUPPORT = 0.6
# Fewer radii than this do not tell a fade.
_LEAST = 0.06 * DIRECTIONS


def look_faded(frame: Frame, circle: Circle, box: Box, dark: Dark) -> Rim | None:
    """Fit the circle to where straight lines through the fade reach black; None where nothing fades.

    The lines give the centre; the radius comes from the mean of all profiles, which has little noise left:
    it is where a curve a t + b t^2 in the depth t below the rim, and black beyond it, fits best.
    """
    relative = np.linspace(_INNER, _OUTER, _SAMPLES, dtype=np.float32)
    weights = ((relative >= _LINE[0]) & (relative <= _LINE[1])).astype(np.float32)
    rim = None
    for _ in range(_ROUNDS):
        found = _fit_fade(frame, circle, box, dark, relative, weights)
        if found is None:
            return None
        rim, slope = found
        circle = rim.circle
        weights = _line_weights(-relative * circle.radius, slope, dark.noise / math.sqrt(_BESIDE))
    return rim


def _line_weights(depth: Array, slope: float, noise: float) -> Array:
    """Weigh the samples of a fade: deep down the scene's texture bends it, near the rim noise drowns it."""
    variance = noise**2 + (_TEXTURE * slope * depth) ** 2
    return np.where(depth > 0, 1 / variance, 0).astype(np.float32)


def _fit_fade(
    frame: Frame, circle: Circle, box: Box, dark: Dark, relative: Array, weights: Array
) -> tuple[Rim, float] | None:
    """Fit once, with the ``weights`` (n,) of the samples; returns the mean slope (levels per px) besides."""
    offsets = relative * np.float32(circle.radius)
    seen = np.flatnonzero(inside_box(circle, float(offsets[-1]), box))
    if len(seen) < _LEAST:
        return None
    profile = _mean_profiles(frame, circle, offsets)[seen]
    outside = profile[:, -_OUTSIDE:].mean(axis=1)
    is_dark = outside < dark.threshold
    # The mean, which clipped noise lifts above the level, is what the lines cross.
    black = float(np.mean(outside[is_dark])) if is_dark.any() else dark.level
    profile -= black
    share = weights / weights.sum()
    middle = share @ offsets
    centered = offsets - middle
    slope = (profile @ (share * centered)) / (share @ (centered * centered))
    height = profile @ share
    bright = profile[:, :_OUTSIDE].mean(axis=1)
    usable = np.flatnonzero(
        is_dark & (bright > dark.contrast) & (slope * offsets[0] > dark.contrast)
    )
    if len(usable) < _LEAST:
        return None
    offset = middle - height[usable] / slope[usable]
    along, used = seen[usable], np.ones(len(usable), np.bool_)
    # Noise moves the crossings of dim profiles more. But those brighter than most tell no more than they do:
    # an instrument shines up to the rim, and a few such profiles would rule the fit.
    trust = np.minimum(bright[usable], np.median(bright[usable])) ** 2
    fitted = fit_offsets(all_bearings()[:, along], offset, used, 0.5, 0.03 * circle.radius, trust)
    if fitted is None:
        return None
    good = fitted.weight > 0.3
    count = int(np.count_nonzero(good))
    if count < _LEAST:
        return None
    average = profile[usable[good]].mean(axis=0)
    if average[0] < _GROWTH * average[_SAMPLES // 3]:
        return None
    hinge = _hinge(offsets, _unclipped(average + black, dark.noise) - _unclipped(black, dark.noise))
    # Outside the window the lines at least lead there, for the next round.
    reach, kink = hinge or (fitted.by.radius, 0.0)
    moved = Circle(circle.x + fitted.by.x, circle.y + fitted.by.y, circle.radius + reach)
    is_circle = (
        _KINK[0] < kink < _KINK[1]
        and _steepest(profile[usable[good]]) <= _FALL
        and count >= _SUPPORT * len(seen)
        and fitted.scale <= _TOLERANCE * circle.radius
        and fitted.center_sigma <= _CENTER_TOLERANCE * circle.radius
    )
    rim = Rim(
        moved,
        fitted.scale,
        fitted.radius_sigma,
        fitted.center_sigma,
        len(seen),
        int(np.count_nonzero(is_dark)),
        len(usable),
        count,
        sharpness=0.0,
        evidence=math.inf if is_circle else 0.0,
        points=RimPoints(angles()[along], used, offset, fitted),
    )
    return rim, float(-np.mean(slope[usable[good]]))


def _unclipped(mean: Any, noise: float) -> Any:
    """Return the levels, black at 0, whose ``mean`` with ``noise`` is this after clipping at 0.

    Noise is clipped at black, which lifts the mean of dark pixels; that would round off the end of a fade.
    """
    ratio, lifted = _clipping()
    lowest = float(lifted[0])
    return noise * np.interp(np.maximum(mean / noise, lowest), lifted, ratio) + np.maximum(
        mean - noise * float(ratio[-1]), 0
    )


@lru_cache(maxsize=1)
def _clipping() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return ratios of level to noise, and of the mean to the noise once the noise is clipped at 0."""
    ratio = np.linspace(-2, 4, 241)
    below = np.array([0.5 + 0.5 * math.erf(z / math.sqrt(2)) for z in ratio])
    return ratio, ratio * below + np.exp(-(ratio**2) / 2) / math.sqrt(2 * math.pi)


def _mean_profiles(frame: Frame, circle: Circle, offsets: Array) -> Array:
    """Sample along radii, each the mean over a few side by side: (DIRECTIONS, n) in 8-bit levels."""
    fine = profiles(frame, circle, offsets[:, None], directions(DIRECTIONS * _BESIDE))
    return fine.reshape(len(offsets), DIRECTIONS, _BESIDE).mean(axis=2).T


@lru_cache(maxsize=1)
def _hinge_bases() -> tuple[NDArray[np.intp], Array]:
    """The candidate samples for the hinge, (n,), and a basis of the curves with each, (n, k, 3)."""
    relative = np.linspace(_INNER, _OUTER, _SAMPLES)
    candidates = np.arange(_SAMPLES // 3, _SAMPLES - 4)
    bases = []
    for k in candidates:
        t = np.maximum(relative[k] - relative, 0)
        bases.append(np.linalg.qr(np.stack([t, t * t, np.ones_like(t)], axis=1))[0])
    return candidates, np.stack(bases).astype(np.float32)


def _steepest(profile: Array) -> float:
    """Return the share of its brightness that the median profile, (n, _SAMPLES) over black, loses at once."""
    smooth = profile[:, :-2] + profile[:, 1:-1] + profile[:, 2:]
    fall = (smooth[:, :-_WITHIN] - smooth[:, _WITHIN:]).max(axis=1) / 3
    return float(np.median(fall / profile[:, :_OUTSIDE].mean(axis=1)))


def _hinge(offsets: Array, average: Array) -> tuple[float, float] | None:
    """Find where a fading profile reaches black; None at the window's ends.

    Returns the offset, px, and the share of the rise from there to the window's inner end that is due to the
    slope at that place, 1 for a straight one.
    """
    candidates, bases = _hinge_bases()
    fitted = average @ bases
    explained = (fitted * fitted).sum(axis=1)
    best = int(explained.argmax())
    if best in (0, len(explained) - 1):
        return None
    before, middle, after = explained[best - 1 : best + 2].tolist()
    fraction = 0.5 * (before - after) / (before - 2 * middle + after)
    reach = float(offsets[candidates[best]]) + fraction * float(offsets[1] - offsets[0])
    depth = np.maximum(offsets[candidates[best]] - offsets, 0)
    curve = np.stack([depth, depth * depth, np.ones_like(depth)], axis=1)
    slope, bend, _ = np.linalg.lstsq(curve, average, rcond=None)[0]
    straight, bent = float(slope * depth[0]), float(bend * depth[0] ** 2)
    return reach, straight / (straight + bent) if straight + bent > 0 else 0.0
