"""How sure a fit is: the covariance of its parameters, with residuals along a line taken as correlated.

Neighbours on an edge err alike, and what bends a line slowly moves the model more than what wiggles. So each
line's residuals are taken apart into waves along it, and one spectrum is told from those of all lines: a
line that a parameter rests on alone has no residuals left to tell its own error by, but errs as others do.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.fft import dct

from ..straightness import Floats, Labels
from .plumb_line import Fit

# The spectrum is told by octaves, in cycles by point. The first one ends here, and takes all that is slower;
# one with fewer waves than FEWEST_WAVES is told along with the next.
SLOWEST = 0.001
FEWEST_WAVES = 20.0
# The place and the direction of a line take its slowest waves.
TAKEN = 2
# Waves quicker than this, cycles by point, tell how noisy a line is beside the others, once there are more of
# them than so many: what bends a line is slower.
QUICK, USUAL_WAVES = 0.03, 20.0


def covariance(fit: Fit, labels: Labels) -> Floats:
    """The covariance (k, k) of the free parameters of a fit to points with line labels (n,).

    The sandwich estimator of a robust fit, with the residuals' spectrum in the middle. What is not known of
    the growth counts, and what is believed beforehand as the fit weighs it.
    """
    order = np.argsort(labels, kind="stable")
    root = np.sqrt(fit.trust[order])
    # A parameter held at a bound moves nothing: its column is zero, and so is its variance.
    unit = np.abs(fit.jacobian).max(axis=0)
    unit[unit == 0] = 1.0
    slopes = root[:, None] * fit.jacobian[order] / unit
    weighted = root * fit.residuals[order]
    size = (weighted / fit.softness) ** 2
    curvature = (1 - size) / (1 + size) ** 2
    belief = np.diag(fit.belief / unit**2)
    # The places of lines are their slowest waves, which straightness alone knows nothing of.
    off, own = fit.places or (np.empty(0), np.empty((0, len(unit))))
    own = own / unit
    inverse = np.linalg.pinv((curvature[:, None] * slopes).T @ slopes + own.T @ own + belief)
    waves = _Waves.of(weighted / (1 + size), slopes, labels[order])
    middle = (waves.power(inverse)[:, None] * waves.slopes).T @ waves.slopes
    middle += fit.pull**2 * belief
    if len(off):
        left = np.maximum(1 - np.einsum("ni,ij,nj->n", own, inverse, own), 0.0)
        middle += (off @ off) / max(float(left.sum()), 1.0) * (own.T @ own)
    whole = inverse @ middle @ inverse / np.outer(unit, unit)
    free = len(fit.free)
    return np.asarray(whole[:free, :free])


@dataclass(frozen=True)
class _Waves:
    """The residuals of all lines as waves along them: the cosine transform of each.

    ``heights`` (n,) px; ``slopes`` (n, k), how the parameters move them; ``frequency`` (n,), cycles by point;
    ``line`` (n,) each one's; ``own`` (n,), 0 where the line's own place and direction took it, else 1.
    """

    heights: Floats
    slopes: Floats
    frequency: Floats
    line: Labels
    own: Floats

    @classmethod
    def of(cls, residuals: Floats, slopes: Floats, labels: Labels) -> _Waves:
        """Transform residuals (n,) px and slopes (n, k) of points with ``labels`` (n,), line after line."""
        both = np.column_stack([residuals, slopes])
        first = np.flatnonzero(np.diff(labels, prepend=-1))
        parts = np.split(both, first[1:])
        waves = np.concatenate([dct(part, axis=0, norm="ortho") for part in parts])
        counts = np.diff(first, append=len(labels))
        number = np.arange(len(labels)) - np.repeat(first, counts)
        frequency = number / (2 * np.repeat(counts, counts))
        return cls(waves[:, 0], waves[:, 1:], frequency, labels, np.where(number < TAKEN, 0.0, 1.0))

    def power(self, inverse: Floats) -> Floats:
        """The variance (n,), px^2, of each wave; ``inverse`` (k, k) of the fit's information.

        That is, by its frequency and by how noisy its line is. The fit took its part of what was there.
        """
        noise = self._noise()
        took = np.einsum("ni,ij,nj->n", self.slopes, inverse, self.slopes)
        left, seen = self.own * np.maximum(1 - took, 0.0), self.own * self.heights**2 / noise
        octave = np.log2(np.maximum(2 * self.frequency / SLOWEST, 1.0)).astype(np.intp)
        total, waves = np.bincount(octave, seen), np.bincount(octave, left)
        spectrum = np.empty(len(total))
        start = 0
        for end in range(1, len(total) + 1):
            if waves[start:end].sum() >= FEWEST_WAVES or end == len(total):
                share = max(float(waves[start:end].sum()), 1e-9)
                spectrum[start:end] = total[start:end].sum() / share
                start = end
        return np.asarray(spectrum[octave] * noise)

    def _noise(self) -> Floats:
        """The variance (n,), px^2, of the quick waves of each one's line, drawn to that of all lines."""
        quick = self.frequency > QUICK
        count = np.bincount(self.line, quick)
        total = np.bincount(self.line, quick * self.heights**2)
        usual = max(float(total.sum() / max(count.sum(), 1.0)), 1e-12)
        return np.asarray((total + USUAL_WAVES * usual) / (count + USUAL_WAVES))[self.line]
