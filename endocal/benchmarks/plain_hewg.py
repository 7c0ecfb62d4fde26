"""HEwG as one would write it down from the article: one configuration at a time, in float64.

The peer that the vectorised ``endocal.calibration.hough.hewg.hewg`` is timed and checked against.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..calibration.hough.hewg import magnification
from ..calibration.hough.votes import ANGLES, Voters
from ..calibration.straightness import LEAST_DENOMINATOR

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Votes:
    """The votes of ``points`` (n, 2) px, ``angles`` (n,) being those of their gradients or the opposite.

    ``step`` px is the height of a cell of the vote map where a model magnifies nothing; ``moved`` (n, 2), in
    cells, is by how much votes are moved in angle and offset.
    """

    points: Floats
    angles: Floats
    step: float
    moved: Floats

    @classmethod
    def of(cls, voters: Voters) -> Votes:
        """Take the very same votes, in the precision that ``voters`` has them."""
        x, y, gx, gy, turn, aside = (
            np.asarray(v, np.float64)
            for v in (voters.x, voters.y, voters.gx, voters.gy, voters.turn, voters.aside)
        )
        angles = np.arctan2(gy, gx)
        moved = 2 * np.pi * turn - angles
        moved -= 2 * np.pi * np.round(moved / (2 * np.pi))
        return cls(
            np.stack([x, y], axis=1),
            2 * np.pi * turn - moved,
            voters.step,
            np.stack([moved * (ANGLES / np.pi), aside], axis=1),
        )


def entropy(votes: Votes, lam: float, cx: float, cy: float) -> float:
    """Return the entropy (eq. 6) of the map of votes.

    A point past the fold, or whose line lies farther out than the map, votes for a cell of its own.
    """
    points = votes.points
    d = points - (cx, cy)
    gx, gy = np.cos(votes.angles), np.sin(votes.angles)
    beta = 1 + lam * (d**2).sum(axis=1)
    u = d / beta[:, None]  # eq. 4, from the centre
    a = -2 * (d[:, 1] * gx - d[:, 0] * gy)
    ux, uy = -(lam * a * d[:, 1] + gx * beta), lam * a * d[:, 0] - gy * beta  # eq. 7
    # The vector of eq. 7 points the other way; of a line's two normals, the one nearer to the gradient.
    turned = np.arctan2(-uy, -ux) - votes.angles
    phi = votes.angles + turned - 2 * np.pi * np.round(turned / (2 * np.pi))
    r = u[:, 0] * np.cos(phi) + u[:, 1] * np.sin(phi)
    half = int(4 * np.hypot(*np.ptp(points, axis=0)) / votes.step)
    cell = votes.step * magnification((d**2).sum(axis=1), np.array([lam])).item()
    column = np.floor(r / cell + votes.moved[:, 1]).astype(int) + half
    # From a quarter turn before the least angle that a gradient has to one after the largest, and some.
    row = np.floor(phi * (ANGLES / np.pi) + votes.moved[:, 0]).astype(int) + 2 * ANGLES
    voting = (beta > LEAST_DENOMINATOR) & (column >= 0) & (column < 2 * half)
    counts = np.bincount(row[voting] * 2 * half + column[voting])
    p = counts[counts > 0] / len(points)
    alone = np.count_nonzero(~voting) / len(points)
    return float(-(p * np.log(p)).sum() + alone * np.log(len(points)))


def grid(votes: Votes, lams: Floats, xs: Floats, ys: Floats) -> Floats:
    """Return the entropy of every combination, (len(lams), len(xs), len(ys)), in a plain loop."""
    out = np.empty((len(lams), len(xs), len(ys)))
    for i, lam in enumerate(lams):
        for j, cx in enumerate(xs):
            for k, cy in enumerate(ys):
                with np.errstate(divide="ignore", invalid="ignore"):  # points on the fold
                    out[i, j, k] = entropy(votes, lam, cx, cy)
    return out
