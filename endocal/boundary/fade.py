"""A rim without a step: the light fades to black towards it, and the circle is where it reaches black."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from .coarse import Dark
from .disc import Box
from .fit import Circle, fit_offsets
from .frame import Frame
from .rim import DIRECTIONS, Rim, directions, inside_box, profiles

Array = NDArray[np.float32]

# The profile, as fractions of the radius: from where the fade is clear to where the outside is.
_INNER, _OUTER, _SAMPLES = -0.16, 0.08, 49
# Where a straight line is fitted to the fade, and how much brighter its start must be than its middle: a
# fade goes on inwards, a soft step does not.
_LINE = (-0.16, -0.03)
_GROWTH = 1.4
_ROUNDS = 3
# The crossings' scatter, of the radius: the scene's own brightness bends every single fade.
_TOLERANCE = 0.02


def look_faded(frame: Frame, circle: Circle, box: Box, dark: Dark) -> Rim | None:
    """Fit the circle to where straight lines through the fade reach black; None where nothing fades.

    The lines give the centre; the radius comes from the mean of all profiles, which has little noise left:
    it is where a curve a t + b t^2 in the depth t below the rim, and black beyond it, fits best.
    """
    rim = None
    for _ in range(_ROUNDS):
        rim = _fit_fade(frame, circle, box, dark)
        if rim is None:
            return None
        circle = rim.circle
    return rim


def _fit_fade(frame: Frame, circle: Circle, box: Box, dark: Dark) -> Rim | None:
    relative = np.linspace(_INNER, _OUTER, _SAMPLES, dtype=np.float32)
    offsets = relative * np.float32(circle.radius)
    seen = np.flatnonzero(inside_box(circle, float(offsets[-1]), box))
    if len(seen) < 0.06 * DIRECTIONS:
        return None
    profile = profiles(frame, circle, offsets)[seen] - np.float32(dark.level)
    line = (relative >= _LINE[0]) & (relative <= _LINE[1])
    t = offsets[line]
    centered = t - t.mean()
    value = profile[:, line]
    mean = value.mean(axis=1)
    slope = (value @ centered) / np.float32(centered @ centered)
    is_dark = profile[:, -5:].mean(axis=1) < dark.threshold - dark.level
    is_fade = is_dark & (slope * t[0] > dark.contrast) & (mean > dark.contrast)
    usable = np.flatnonzero(is_fade)
    if len(usable) < 0.06 * DIRECTIONS:
        return None
    offset = t.mean() - mean[usable] / slope[usable]
    cosine, sine = directions()
    chosen = seen[usable]
    fitted = fit_offsets(cosine[chosen], sine[chosen], offset, 0.5, 0.03 * circle.radius)
    if fitted is None:
        return None
    good = fitted.weight > 0.3
    if np.count_nonzero(good) < 0.06 * DIRECTIONS:
        return None
    average = profile[usable[good]].mean(axis=0)
    reach = _hinge(offsets, average)
    if reach is None or average[0] < _GROWTH * average[_SAMPLES // 3]:
        return None
    moved = Circle(circle.x + fitted.by.x, circle.y + fitted.by.y, circle.radius + reach)
    return Rim(
        moved,
        fitted.scale,
        fitted.radius_sigma,
        len(seen),
        int(np.count_nonzero(is_dark)),
        len(usable),
        int(np.count_nonzero(good)),
        sharpness=0.0,
        evidence=math.inf if fitted.scale <= _TOLERANCE * circle.radius else 0.0,
    )


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


def _hinge(offsets: Array, average: Array) -> float | None:
    """Find the offset, px, at which a fading profile reaches black; None at the window's ends."""
    candidates, bases = _hinge_bases()
    fitted = average @ bases
    explained = (fitted * fitted).sum(axis=1)
    best = int(explained.argmax())
    if best in (0, len(explained) - 1):
        return None
    before, middle, after = explained[best - 1 : best + 2].tolist()
    fraction = 0.5 * (before - after) / (before - 2 * middle + after)
    return float(offsets[candidates[best]]) + fraction * float(offsets[1] - offsets[0])
