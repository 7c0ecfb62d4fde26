"""How far a lens departs from the division model, told from noise; and what a fit should then make small.

Where the model holds, each edge point is off by the noise of its measurement, the same all over the picture.
Where a lens bends otherwise, lines stay bent by some amount, and what counts is how straight they look in the
*corrected* picture: there a departure is as long as the picture is magnified.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..straightness import Floats, Labels, Undistorted, fit_lines
from .plumb_line import robust_sigma

# Residuals are averaged over so many points along a line: noise of the measurement gets small beside what
# bends all of a line. A line tells something from FEWEST_BLOCKS blocks on.
BLOCK = 10
FEWEST_BLOCKS = 4
# An edge is never measured better than to this, px.
LEAST_NOISE = 0.02
# A point is trusted by at most this many times the trust in one where the picture is magnified as usual.
MOST_MAGNIFIED = 10.0


@dataclass(frozen=True)
class Misfit:
    """Standard deviations, px, of blocks of residuals: from one to the next, and along lines."""

    noise: float
    bend: float

    @property
    def ratio(self) -> float:
        """The bend over the noise: well below 1 where the model holds."""
        return self.bend / max(self.noise, LEAST_NOISE)


def misfit(residuals: Floats, labels: Labels, outlying: float) -> Misfit:
    """Split residuals (n,) px along lines into noise and bend; those beyond ``outlying`` px are left out."""
    means, steps = [], []
    for line in range(int(labels.max()) + 1):
        own = residuals[(labels == line) & (np.abs(residuals) < outlying)]
        blocks = own[: len(own) // BLOCK * BLOCK].reshape(-1, BLOCK).mean(axis=1)
        if len(blocks) < FEWEST_BLOCKS:
            continue
        means.append(blocks)
        # A block less its neighbours' mean: 1 + 1/4 + 1/4 times the noise's variance, and of a bend little.
        steps.append((blocks[1:-1] - (blocks[:-2] + blocks[2:]) / 2) / np.sqrt(1.5))
    if not means:
        return Misfit(0.0, 0.0)
    total, noise = robust_sigma(np.concatenate(means)), robust_sigma(np.concatenate(steps))
    return Misfit(noise, float(np.sqrt(max(total**2 - noise**2, 0.0))))


def trust_by_magnification(points: Floats, labels: Labels, params: Floats, ratio: float) -> Floats:
    """Weights (n,), 1 in the mean, of points whose variance is noise plus bend over magnification, squared.

    ``ratio``: bend over noise. The magnification is that across the lines, by the model ``params``.
    """
    at = Undistorted.of(points, params)
    lines = fit_lines(at.u, labels, int(labels.max()) + 1, at.denominator**2)
    scale = at.scale(lines.normals[labels])
    scale = np.minimum(scale / np.median(scale), MOST_MAGNIFIED)
    trust = 1 / (1 + (ratio / scale) ** 2)
    return np.asarray(trust / trust.mean())
