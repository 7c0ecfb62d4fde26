"""Points put back on their edges from where light that falls off draws them: toward the lit middle.

Light that changes by a share ``a`` of itself for each px, across an edge that the optics blurred by b before
and that is smoothed by s after, moves its steepest place by a (2 b^2 + s^2) toward the light, whichever side
of the edge is bright: lines seen from both sides do not tell. All lines then seem a little more bent.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import ndtr

from ..straightness import Floats
from .courses import normals_of
from .profiles import BETWEEN, DIFFERENCES, SMOOTHING, Measured
from .step_edge import NARROWEST, WIDEST, WINDOW

# The light is a parabola over the picture, fitted to the bright side of so many points in so many rounds;
# what lies so many usual deviations beside it, as highlights do, counts ever less.
ENOUGH_POINTS, ROUNDS, SOFTNESS = 4000, 6, 2.0
# It is nowhere taken to be less than this share of what is usual, and draws nothing by more than so many px.
DARKEST, MOST_OFF = 0.1, 0.2


@dataclass(frozen=True)
class Light:
    """How bright a white sheet looks over the picture: a parabola.

    ``terms`` (6,), grey levels, of 1, x, y, x^2, x y and y^2 in units of ``size`` px from ``middle`` (2,); it
    is nowhere taken to be less than ``least``.
    """

    terms: Floats
    middle: Floats
    size: float
    least: float

    @classmethod
    def of(cls, lines: Measured) -> Light:
        """Tell it from the bright sides of edges that are all of one sheet."""
        middle = lines.points.mean(axis=0)
        size = max(float(np.abs(lines.points - middle).max()), 1.0)
        few = slice(None, None, max(1, len(lines.points) // ENOUGH_POINTS))
        level, columns = lines.levels[few, 1], _columns((lines.points[few] - middle) / size)
        weight = np.ones_like(level)
        for _ in range(ROUNDS):
            terms = np.linalg.lstsq(columns * weight[:, None], level * weight, rcond=None)[0]
            off = np.abs(level - columns @ terms)
            usual = max(float(np.median(off)) / 0.6745, 1.0)
            weight = 1 / np.sqrt(1 + (off / (SOFTNESS * usual)) ** 2)
        return cls(np.asarray(terms), middle, size, max(DARKEST * float(np.median(level)), 1.0))

    def change(self, points: Floats) -> Floats:
        """By which share of itself it changes in a px of x and of y, (n, 2), at ``points`` (n, 2) px."""
        at = (points - self.middle) / self.size
        x, y = at.T
        _, fx, fy, fxx, fxy, fyy = self.terms
        slopes = np.stack([fx + 2 * fxx * x + fxy * y, fy + fxy * x + 2 * fyy * y], axis=1)
        level = np.maximum(_columns(at) @ self.terms, self.least)
        return np.asarray(slopes / self.size / level[:, None])


def out_of_the_light(lines: Measured, drawn: Floats, params: Floats, light: Light) -> Measured:
    """Return the points with what light draws them off taken away.

    ``drawn`` (count,) px^2: how far it draws those of each line, per share that it changes by in a px;
    ``params``: the model under which the lines run, see ``profiles.measure``.
    """
    across = normals_of(lines.points, lines.labels, lines.points, lines.labels, params)
    off = np.einsum("ij,ij->i", light.change(lines.points), across) * drawn[lines.labels]
    off = np.clip(off, -MOST_OFF, MOST_OFF)
    return replace(lines, points=lines.points - off[:, None] * across)


def _columns(at: Floats) -> Floats:
    x, y = at.T
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1)


def steepest_drawn(blur: Floats, smoothing: Floats | float) -> Floats:
    """How far, px^2, light draws the steepest places of edges of this ``blur``, smoothed, px."""
    return np.asarray(2 * blur**2 + smoothing**2 + DIFFERENCES + BETWEEN)


def fitted_drawn(blur: Floats) -> Floats:
    """How far, px^2, light draws what ``step_edge.fit_steps`` fits to edges of this ``blur``, px."""
    return np.array([_fitted_drawn(float(b)) for b in blur])


def _fitted_drawn(blur: float) -> float:
    """What light adds to a step, as far as the step's place explains it beside its height and level."""
    after = SMOOTHING**2 + BETWEEN
    width = np.sqrt(blur**2 + after)
    reach = int(np.clip(round(WINDOW * width), NARROWEST, WIDEST))
    x = np.arange(-reach, reach + 1.0)
    step = ndtr(x / width)
    slope = np.exp(-0.5 * (x / width) ** 2) / (np.sqrt(2 * np.pi) * width)
    columns = np.stack([slope, step, np.ones_like(x)], axis=1)
    return -float(np.linalg.lstsq(columns, x * step + after * slope, rcond=None)[0][0])
