"""A rim without a step: the light fades to black towards it, and the circle is where it reaches black."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .coarse import Dark, Luma
from .disc import Box
from .fit import Circle, fit_offsets
from .rim import DIRECTIONS, Rim, directions, inside_box, profiles

Array = NDArray[np.float32]

# The profile, as fractions of the radius: from where the fade is clear to where the outside is.
_INNER, _OUTER, _SAMPLES = -0.16, 0.08, 49
# Where a straight line is fitted to the fade, and how much brighter its start must be than its middle: a
# fade goes on inwards, a soft step does not.
_LINE = (-0.16, -0.03)
_GROWTH = 1.4
_ROUNDS = 3


def look_faded(luma: Luma, circle: Circle, box: Box, dark: Dark, pixel_aspect: float) -> Rim | None:
    """Fit the circle to where straight lines through the fade reach black; None where nothing fades.

    The lines give the centre; the radius comes from the mean of all profiles, which has little noise left:
    it is where a curve a t + b t^2 in the depth t below the rim, and black beyond it, fits best.
    """
    rim = None
    for _ in range(_ROUNDS):
        rim = _fit_fade(luma, circle, box, dark, pixel_aspect)
        if rim is None:
            return None
        circle = rim.circle
    return rim


def _fit_fade(luma: Luma, circle: Circle, box: Box, dark: Dark, pixel_aspect: float) -> Rim | None:
    relative = np.linspace(_INNER, _OUTER, _SAMPLES, dtype=np.float32)
    offsets = relative * np.float32(circle.radius)
    seen = np.flatnonzero(inside_box(circle, float(offsets[-1]), box))
    if len(seen) < 0.06 * DIRECTIONS:
        return None
    profile = profiles(luma, circle, offsets, pixel_aspect)[seen] - np.float32(dark.level)
    line = (relative >= _LINE[0]) & (relative <= _LINE[1])
    t = offsets[line]
    centered = t - t.mean()
    value = profile[:, line]
    mean = value.mean(axis=1)
    slope = (value @ centered) / np.float32(centered @ centered)
    contrast = np.float32(dark.threshold - dark.level)
    is_dark = profile[:, -5:].mean(axis=1) < contrast
    is_fade = is_dark & (slope * t[0] > contrast) & (mean > contrast)
    usable = np.flatnonzero(is_fade)
    if len(usable) < 0.06 * DIRECTIONS:
        return None
    offset = t.mean() - mean[usable] / slope[usable]
    cosine, sine = directions()
    chosen = seen[usable]
    fitted = fit_offsets(cosine[chosen], sine[chosen], offset, floor=0.5)
    if fitted is None:
        return None
    shift, weight, scale = fitted
    good = weight > 0.3
    if np.count_nonzero(good) < 0.06 * DIRECTIONS:
        return None
    average = profile[usable[good]].mean(axis=0)
    reach = _hinge(offsets, average)
    if reach is None or average[0] < _GROWTH * average[_SAMPLES // 3]:
        return None
    moved = Circle(circle.x + shift.x, circle.y + shift.y, circle.radius + reach)
    on_circle = int(np.count_nonzero(good))
    return Rim(moved, scale, len(seen), int(np.count_nonzero(is_dark)), len(usable), on_circle)


def _hinge(offsets: Array, average: Array) -> float | None:
    """Find the offset, px, at which a fading profile reaches black; None at the window's ends."""
    spacing = float(offsets[1] - offsets[0])
    candidates = np.arange(_SAMPLES // 3, _SAMPLES - 4)
    errors = np.array([_hinge_error(offsets, average, float(offsets[k])) for k in candidates])
    best = int(errors.argmin())
    if best in (0, len(errors) - 1):
        return None
    before, middle, after = errors[best - 1 : best + 2]
    fraction = 0.5 * (before - after) / (before - 2 * middle + after)
    return float(offsets[candidates[best]]) + float(fraction) * spacing


def _hinge_error(offsets: Array, average: Array, reach: float) -> float:
    """Return the squared error of black + a t + b t^2 with t = reach - offset where positive."""
    t = np.maximum(np.float32(reach) - offsets, 0).astype(np.float64)
    basis = np.stack([t, t * t, np.ones_like(t)])
    solution, *_ = np.linalg.lstsq(basis.T, average.astype(np.float64), rcond=None)
    residual = average - solution @ basis
    return float(residual @ residual)
