"""What light that falls off over a sheet does to edges, taken off: it draws them toward the lit middle.

Light that changes by a share ``a`` of itself for each px, across an edge that is then blurred by b in the
optics and smoothed by s, moves its steepest place by a (b^2 + s^2) toward the light, whichever side of the
edge is bright: lines seen from both sides do not tell. All lines then seem a little more bent. And grey
levels, read some px beside an edge, are higher on the side of the light, whatever the edge is.

Where a camera shows the light to the power 1 / gamma, what one sees changes by a / gamma. Blur has done its
part before: it moves the edge, as it is shown, by a b^2 still, that is by gamma b^2 for a share of what one
sees; but what of b^2 comes from the levels' slope along the blurred edge is as it was. In all (2 - gamma) b^2
+ s^2.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import ndtr

from ..straightness import Floats
from .courses import leading, normals_of
from .profiles import BESIDE, BETWEEN, DIFFERENCES, SMOOTHING, Measured
from .step_edge import NARROWEST, WIDEST, WINDOW

# The light on a sheet falls off as a parabola or, from a lamp near by, as one over a parabola or its square;
# a camera shows a power of it. One is fitted to the levels beside so many points in so many rounds; what lies
# so many usual deviations beside it, as highlights do, counts ever less. Another power must leave less by
# this share; less than so many grey levels is nothing.
POWERS = (1.0, 1 / 1.5, 1 / 2, 1 / 2.5, 1 / 3, 1.5, 2.0, 2.5, 4.0, 6.0, -1 / 2, -1.0, -2.0)
BETTER = 0.98
FINEST = 0.05
ENOUGH_POINTS, ROUNDS, SOFTNESS = 4000, 6, 2.0
# Nearer than this to where the bright side changes, px, levels are those of both sides.
CROSSING = 6.0
# It is nowhere taken to be less than this share of what is usual, or as many times more, and draws nothing
# by more than so many px.
DARKEST, MOST_OFF = 0.1, 0.2


@dataclass(frozen=True)
class Shade:
    """How bright a sheet of one colour looks over the picture: a power of a parabola, ``usual`` times.

    ``terms`` (6,) of 1, x, y, x^2, x y and y^2 in units of ``size`` px from ``middle`` (2,).
    """

    terms: Floats
    middle: Floats
    size: float
    power: float
    usual: float

    @classmethod
    def of(cls, points: Floats, levels: Floats, power: float) -> Shade:
        """Fit it to grey ``levels`` (n,) at ``points`` (n, 2) px."""
        middle = points.mean(axis=0)
        size = max(float(np.abs(points - middle).max()), 1.0)
        usual = max(float(np.median(levels)), 1.0)
        shares = np.maximum(levels / usual, 0.0 if power > 0 else DARKEST) ** (1 / power)
        terms = _parabola(_columns((points - middle) / size), shares)
        return cls(terms, middle, size, power, usual)

    def level(self, points: Floats) -> Floats:
        """The grey level (n,) at ``points`` (n, 2) px."""
        columns = _columns((points - self.middle) / self.size)
        return np.asarray(self.usual * self._parabola(columns) ** self.power)

    def slope(self, points: Floats) -> Floats:
        """By how many grey levels it changes in a px of x and of y, (n, 2), at ``points`` (n, 2) px."""
        at = (points - self.middle) / self.size
        x, y = at.T
        _, fx, fy, fxx, fxy, fyy = self.terms
        slopes = np.stack([fx + 2 * fxx * x + fxy * y, fy + fxy * x + 2 * fyy * y], axis=1)
        steep = self.usual * self.power * self._parabola(_columns(at)) ** (self.power - 1)
        return np.asarray(slopes / self.size * steep[:, None])

    def _parabola(self, columns: Floats) -> Floats:
        """The parabola (n,), held where levels would leave ``DARKEST`` times the usual one to its inverse."""
        ends = DARKEST ** (1 / self.power), (1 / DARKEST) ** (1 / self.power)
        return np.asarray(np.clip(columns @ self.terms, min(ends), max(ends)))


@dataclass(frozen=True)
class Light:
    """How ``bright`` white and how ``dark`` black look over the picture.

    A veil of stray light lies over both: what falls off is how much they differ, at least ``least``.
    """

    bright: Shade
    dark: Shade
    least: float

    @property
    def gamma(self) -> float:
        """Of the camera, as the light tells it.

        It brightens, if anything: a light that falls off faster than a parabola, as cosines to the fourth do,
        is likelier than a camera that darkens, and one over a parabola is a lamp's.
        """
        return 1 / self.bright.power if 0 < self.bright.power < 1 else 1.0

    @classmethod
    def of(cls, lines: Measured, params: Floats) -> Light:
        """Tell it from both sides of edges of one sheet; ``params`` as ``profiles.measure`` takes them."""
        away = lines.from_crossings()
        clear = np.flatnonzero(away >= min(CROSSING, float(np.median(away))))
        clear = clear[:: max(1, len(clear) // ENOUGH_POINTS)]
        places = [at[clear] for at in _beside(lines, _toward_bright(lines, params))]
        seen = lines.levels[clear, :2].T
        best, least_off = None, np.inf
        for power in POWERS:
            dark, bright = (Shade.of(*one, power) for one in zip(places, seen, strict=True))
            levels = dark.level(places[0]), bright.level(places[1])
            off = max(float(np.median(np.abs(levels - seen), axis=1).sum()), FINEST)
            if best is None or off < BETTER * least_off:
                least = max(DARKEST * (bright.usual - dark.usual), 1.0)
                best, least_off = cls(bright, dark, least), off
        assert best is not None
        return best

    def height(self, points: Floats) -> Floats:
        """How many grey levels (n,) white and black differ by at ``points`` (n, 2) px."""
        return np.maximum(self.bright.level(points) - self.dark.level(points), self.least)

    def change(self, points: Floats) -> Floats:
        """By which share of itself that changes in a px of x and of y, (n, 2), at ``points`` (n, 2) px."""
        slope = self.bright.slope(points) - self.dark.slope(points)
        return np.asarray(slope / self.height(points)[:, None])

    def evened(self, levels: Floats, points: Floats) -> Floats:
        """Grey ``levels`` (n,) seen at ``points`` (n, 2) px, as they would be where the light is as usual."""
        share = (levels - self.dark.level(points)) / self.height(points)
        return self.dark.usual + (self.bright.usual - self.dark.usual) * share


def out_of_the_light(
    lines: Measured,
    drawn: Floats,
    blur: Floats,
    smoothing: Floats | float,
    params: Floats,
    light: Light,
) -> Measured:
    """Return the points with what light draws them off taken away, and levels as in even light.

    ``drawn`` (count,) px^2: how far it draws those of each line, per share that it changes by in a px;
    ``blur`` (count,) and ``smoothing`` px, (count,) or one: what made the edges as
    wide as they are where levels are read; ``params``: the model under which the lines run, see
    ``profiles.measure``.
    """
    bright = _toward_bright(lines, params)
    change = np.einsum("ij,ij->i", light.change(lines.points), bright)
    off = np.clip(change * drawn[lines.labels], -MOST_OFF, MOST_OFF)
    # A blurred edge is higher on both sides where the light grows across it. By as much levels would seem to
    # depend on where the light is, and growth, fitted by them, would undo what is taken off here.
    width = np.sqrt(blur**2 + smoothing**2 + BETWEEN)
    tail = BESIDE / width
    slope = np.exp(-0.5 * tail**2) / (np.sqrt(2 * np.pi) * width)
    before_gamma = (light.gamma - 1) * blur**2
    higher = (width**2 + before_gamma) * slope / (2 * ndtr(tail) - 1)
    level_off = higher[lines.labels] * change * light.height(lines.points)
    sides = zip(lines.levels.T[:2], _beside(lines, bright), strict=True)
    levels = [light.evened(level - level_off, places) for level, places in sides]
    white = light.bright.level(lines.points)
    return replace(
        lines,
        points=lines.points - off[:, None] * bright,
        levels=np.stack([*levels, white], axis=1),
    )


def _toward_bright(lines: Measured, params: Floats) -> Floats:
    """Unit vectors (n, 2) across the lines, toward the bright side of each point."""
    across = normals_of(lines.points, lines.labels, lines.points, lines.labels, params)
    return across * (leading(lines.points, lines.labels, across) * lines.sides)[:, None]


def _beside(lines: Measured, bright: Floats) -> tuple[Floats, Floats]:
    """Where the levels of the dark and of the bright sides were read, (n, 2) px each."""
    return lines.points - BESIDE * bright, lines.points + BESIDE * bright


def _columns(at: Floats) -> Floats:
    x, y = at.T
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1)


def _parabola(columns: Floats, values: Floats) -> Floats:
    """The terms (6,) that explain most of ``values`` (n,)."""
    weight = np.ones_like(values)
    for _ in range(ROUNDS):
        weighted = columns * weight[:, None]
        # A parabola in such units is as well told by these, in a fraction of the time.
        square, right = weighted.T @ weighted, weighted.T @ (values * weight)
        terms = np.linalg.lstsq(square, right, rcond=None)[0]
        off = np.abs(values - columns @ terms)
        usual = max(float(np.median(off)) / 0.6745, 0.005)
        weight = 1 / np.sqrt(1 + (off / (SOFTNESS * usual)) ** 2)
    return np.asarray(terms)


def steepest_drawn(blur: Floats, smoothing: Floats | float, gamma: float) -> Floats:
    """How far, px^2, light draws the steepest places of edges of this ``blur``, smoothed, px.

    ``gamma``: the camera's.
    """
    return np.asarray((2 - gamma) * blur**2 + smoothing**2 + DIFFERENCES + BETWEEN)


def fitted_drawn(blur: Floats) -> Floats:
    """How far, px^2, light draws what ``step_edge.fit_steps`` fits to edges of this ``blur``, px.

    Gamma makes an edge lopsided, and what that does to the fit outweighs what it does to the light.
    """
    return np.array([_fitted_drawn(float(b)) for b in blur])


def _fitted_drawn(blur: float) -> float:
    """What light adds to a step, as far as the step's place explains it beside its height and level."""
    width = np.sqrt(blur**2 + SMOOTHING**2 + BETWEEN)
    reach = int(np.clip(round(WINDOW * width), NARROWEST, WIDEST))
    x = np.arange(-reach, reach + 1.0)
    step = ndtr(x / width)
    slope = np.exp(-0.5 * (x / width) ** 2) / (np.sqrt(2 * np.pi) * width)
    columns = np.stack([slope, step, np.ones_like(x)], axis=1)
    return -float(np.linalg.lstsq(columns, x * step + width**2 * slope, rcond=None)[0][0])
