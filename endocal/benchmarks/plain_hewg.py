"""HEwG as one would write it down from the article: one configuration at a time, in float64.

The peer that the vectorised ``endocal.calibration.hough.hewg`` is timed and checked against.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..calibration.hough import magnification
from ..calibration.straightness import LEAST_DENOMINATOR
from ..calibration.votes import ANGLES

Floats = NDArray[np.float64]


def entropy(
    points: Floats, gradients: Floats, step: float, lam: float, cx: float, cy: float
) -> float:
    """Return the entropy (eq. 6) of the votes of ``points`` (n, 2) px with unit ``gradients`` (n, 2).

    ``step`` px is the height of a cell of the vote map where the model magnifies nothing. A point past the
    fold, or whose line lies farther out than the map, votes for a cell of its own.
    """
    d = points - (cx, cy)
    gx, gy = gradients.T
    beta = 1 + lam * (d**2).sum(axis=1)
    u = d / beta[:, None]  # eq. 4, from the centre
    a = -2 * (d[:, 1] * gx - d[:, 0] * gy)
    ux, uy = -(lam * a * d[:, 1] + gx * beta), lam * a * d[:, 0] - gy * beta  # eq. 7
    phi = np.arctan2(uy, ux) % np.pi
    r = u[:, 0] * np.cos(phi) + u[:, 1] * np.sin(phi)
    half = int(4 * np.hypot(*np.ptp(points, axis=0)) / step)
    cell = step * magnification((d**2).sum(axis=1), np.array([lam])).item()
    column = np.floor(r / cell).astype(int) + half
    row = np.minimum((phi * (ANGLES / np.pi)).astype(int), ANGLES - 1)
    voting = (beta > LEAST_DENOMINATOR) & (column >= 0) & (column < 2 * half)
    votes = np.bincount(row[voting] * 2 * half + column[voting])
    p = votes[votes > 0] / len(points)
    alone = np.count_nonzero(~voting) / len(points)
    return float(-(p * np.log(p)).sum() + alone * np.log(len(points)))


def grid(
    points: Floats, gradients: Floats, step: float, lams: Floats, xs: Floats, ys: Floats
) -> Floats:
    """Return the entropy of every combination, (len(lams), len(xs), len(ys)), in a plain loop."""
    out = np.empty((len(lams), len(xs), len(ys)))
    for i, lam in enumerate(lams):
        for j, cx in enumerate(xs):
            for k, cy in enumerate(ys):
                with np.errstate(divide="ignore", invalid="ignore"):  # points on the fold
                    out[i, j, k] = entropy(points, gradients, step, lam, cx, cy)
    return out
