"""Residuals along lines as waves: neighbours on an edge err alike, and what is slow moves a model most.

Each line's residuals are taken apart into waves along it, and one spectrum is told from those of all lines: a
line that a parameter rests on alone has no residuals left to tell its own error by, but errs as others do.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.fft import dct

from ..straightness import Floats, Labels

# The spectrum is told by octaves, in cycles by point. The first one ends here, and takes all that is slower;
# one with fewer waves than FEWEST_WAVES is told along with the next.
SLOWEST = 0.001
FEWEST_WAVES = 20.0
# The place and the direction of a line take its slowest waves.
TAKEN = 2
# What is smooth over the picture bends lines in waves of a number less than this, 0 being a line's place.
SLOW = 16
# Waves quicker than this, cycles by point, tell how noisy a line is beside the others, once there are more of
# them than so many: what bends a line is slower.
QUICK, USUAL_WAVES = 0.03, 20.0


@dataclass(frozen=True)
class Waves:
    """The residuals of all lines as waves along them: the cosine transform of each.

    ``heights`` (n,) px; ``slopes`` (n, k), how the parameters move them; ``frequency`` (n,), cycles by point;
    ``line`` (n,) each one's, ``number`` (n,) from 0 on each; ``own`` (n,), 0 where the line's own place and
    direction took it, else 1.
    """

    heights: Floats
    slopes: Floats
    frequency: Floats
    line: Labels
    number: Labels
    own: Floats

    @classmethod
    def of(cls, residuals: Floats, slopes: Floats, labels: Labels) -> Waves:
        """Transform residuals (n,) px and slopes (n, k) of points with ``labels`` (n,), line after line."""
        both = np.column_stack([residuals, slopes])
        first = np.flatnonzero(np.diff(labels, prepend=-1))
        parts = np.split(both, first[1:])
        waves = np.concatenate([dct(part, axis=0, norm="ortho") for part in parts])
        counts = np.diff(first, append=len(labels))
        number = np.arange(len(labels)) - np.repeat(first, counts)
        frequency = number / (2 * np.repeat(counts, counts))
        own = np.where(number < TAKEN, 0.0, 1.0)
        return cls(waves[:, 0], waves[:, 1:], frequency, labels, number, own)

    @property
    def slow(self) -> NDArray[np.bool_]:
        """Which waves (n,) are slow, and not their line's own."""
        return np.asarray((self.own > 0) & (self.number < SLOW))

    def slow_ones_of(self, values: Floats, weights: Floats) -> Floats:
        """The slow waves (s, c) alone of other columns of values (n, c) of the points, times weights (n,)."""
        first = np.flatnonzero(self.number == 0)
        counts = np.diff(first, append=len(self.number))
        count = np.repeat(counts, counts)
        angles = np.pi / count * (self.number + 0.5)
        cosines = (np.sqrt(2 / count) * weights)[:, None] * np.cos(
            np.arange(TAKEN, SLOW) * angles[:, None]
        )
        out = [
            cosines[start : start + n, : max(n - TAKEN, 0)].T @ values[start : start + n]
            for start, n in zip(first, counts, strict=True)
        ]
        return np.concatenate(out)

    def left(self, inverse: Floats) -> Floats:
        """How much of each wave (n,) a fit left, 0 to 1; ``inverse`` (k, k) of its information."""
        took = np.einsum("ni,ij,nj->n", self.slopes, inverse, self.slopes)
        return np.asarray(self.own * np.maximum(1 - took, 0.0))

    def power(self, heights: Floats, left: Floats) -> Floats:
        """The variance (n,), px^2, of each wave, by its frequency and by how noisy its line is.

        It is told by the ``heights`` (n,) of what is left of them, ``left`` (n,).
        """
        noise = self.noise()
        seen = self.own * heights**2 / noise
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

    def noise(self) -> Floats:
        """The variance (n,), px^2, of the quick waves of each one's line, drawn to that of all lines."""
        quick = self.frequency > QUICK
        count = np.bincount(self.line, quick)
        total = np.bincount(self.line, quick * self.heights**2)
        usual = max(float(total.sum() / max(count.sum(), 1.0)), 1e-12)
        return np.asarray((total + USUAL_WAVES * usual) / (count + USUAL_WAVES))[self.line]
