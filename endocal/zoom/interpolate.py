"""Interpolation over a handful of knots, in plain floats: a zoom table is read once per video frame."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence


def linear(x: Sequence[float], y: Sequence[float], at: float) -> float:
    """Interpolate piecewise linearly over ascending ``x``; constant outside."""
    i = _segment(x, at)
    width = x[i + 1] - x[i]
    t = min(max((at - x[i]) / width, 0.0), 1.0) if width else 0.5
    return y[i] + t * (y[i + 1] - y[i])


def line_slope(x: Sequence[float], y: Sequence[float]) -> float:
    """Return the slope of the least-squares line through the points."""
    mean_x, mean_y = sum(x) / len(x), sum(y) / len(y)
    over = sum((a - mean_x) * (b - mean_y) for a, b in zip(x, y, strict=True))
    return over / sum((a - mean_x) ** 2 for a in x)


class MonotoneCurve:
    """A curve through the knots that never overshoots them, with a continuous slope.

    Cubic Hermite pieces with the slopes of Fritsch and Butland (1984, doi:10.1137/0905021), level at
    both ends and constant outside, so that the curve stays smooth there too.
    """

    def __init__(self, x: Sequence[float], y: Sequence[float]) -> None:
        self._x = list(x)
        self._y = list(y)
        self._slope = [0.0] * len(x)
        for i in range(1, len(x) - 1):
            left, right = x[i] - x[i - 1], x[i + 1] - x[i]
            before, after = (y[i] - y[i - 1]) / left, (y[i + 1] - y[i]) / right
            if before * after > 0:
                w1, w2 = 2 * right + left, right + 2 * left
                self._slope[i] = (w1 + w2) / (w1 / before + w2 / after)

    def __call__(self, at: float) -> float:
        """Evaluate the curve."""
        x, y, m = self._x, self._y, self._slope
        i = _segment(x, at)
        width = x[i + 1] - x[i]
        t = min(max((at - x[i]) / width, 0.0), 1.0)
        s = 1 - t
        return (
            y[i] * s * s * (1 + 2 * t)
            + y[i + 1] * t * t * (1 + 2 * s)
            + width * t * s * (m[i] * s - m[i + 1] * t)
        )


def _segment(x: Sequence[float], at: float) -> int:
    return min(max(bisect_right(x, at) - 1, 0), len(x) - 2)
