"""The last fit of a board: its lines are those of one flat, regular grid, as far as the picture bears it out.

The straightness of each line tells the model. A board tells more: its rows and columns are printed at one
distance from the next, on a plane. Where each line runs by its own points is compared with where the grid has
it. How far a board is from regular is not known beforehand: print, glue and what the lens does besides move
its lines, by a standard deviation that their departures tell. On a board that is regular to the noise the
model is known about 1.5 times as well; on one that is not the grid has no say.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq, least_squares
from scipy.sparse import csr_array

from ..board.numbered import Numbered, numbered_lines
from ..board.pencils import Pencils, pencils_through
from ..measure.growth import growth_columns, smooth_growth
from ..measure.profiles import Measured
from ..straightness import Floats, Labels, residuals
from .line_places import LinePlaces
from .plumb_line import ALIKE, Fit, Places, robust_sigma

# Of all points so many tell where the lines run.
ENOUGH_POINTS = 4000
# Rounds in which the lines' places, and how irregular the boards are, are found anew; till that changes by
# less than SETTLED px.
ROUNDS = 4
SETTLED = 1e-3
# A line farther from its place than so many standard deviations counts ever less (Cauchy): its number may be
# wrong.
SOFTNESS = 4.0
# What moves the lines by less than this share of what does most does not move them.
LEAST_SIZE = 1e-9
# Half of all squares of normal deviates are smaller than this.
MEDIAN_SQUARE = 0.455


def fit_grid(measured: Measured, view: Labels, fit: Fit, reach: float) -> Fit | None:
    """Fit the model of ``fit``, and a grid for each board, to lines that are measured and fitted already.

    What straightness tells of the model and of growth is summed up by the information of ``fit`` about its
    answer. ``view`` (n,): which view each point is from; ``reach`` px: how far the points go. None where no
    board's lines have a place.
    """
    lines = numbered_lines(measured, view, fit.params)
    at_a_bound = not fit.jacobian[:, : len(fit.free)].any(axis=0).all()
    if len(lines.line) == 0 or at_a_bound:
        return None
    told = _Told.by(fit)
    columns = growth_columns(measured.sides, measured.levels, measured.labels)
    step = max(1, len(measured.points) // ENOUGH_POINTS)
    few = measured.in_order(np.arange(0, len(measured.points), step), measured.labels[::step])
    weights = step * told.weights[::step]

    seen = columns[::step]
    if not lines.placed.all():
        # Bars' edges show how far they have grown by where they are: whatever smooth growth there is is told.
        seen = np.hstack([seen, smooth_growth(few.points, few.sides)])

    def places_under(params: Floats) -> LinePlaces:
        return LinePlaces.of(few, lines.line, params, weights, seen)

    near = _Near.of(told, np.zeros(len(told.root)), places_under)
    grids = _Grids.through(near.places, lines, reach, seen.shape[1] - columns.shape[1])
    y, irregular = near.y, 0.0
    for _ in range(ROUNDS):
        shares = 1 / np.sqrt(1 + near.places.mass * irregular**2 / told.noise)
        y, grids = _solved(near, grids, shares)
        before, irregular = irregular, _irregularity(near, grids, y)
        near = _Near.of(told, y, places_under)
        if abs(irregular - before) < SETTLED:
            break
    params, grown = told.params(y), told.grown(y)
    left = residuals(
        measured.points, measured.labels, params, told.weights, measured.sides, columns @ grown
    )
    return replace(
        fit,
        params=params,
        growth=grown,
        residuals=left,
        sigma=robust_sigma(left),
        places=_places(near, grids, shares, few.labels, step),
    )


@dataclass(frozen=True)
class _Told:
    """What a fit tells of its unknowns, k free parameters and how much there is of each of g growths.

    ``root`` (u, u) times a change of them (u,) is y, whose squares add up to those by which the residuals
    of the points, and what is believed, get worse. ``noise``: the variance of a sum over points, px^2.
    """

    fit: Fit
    weights: Floats
    root: Floats
    noise: float

    @classmethod
    def by(cls, fit: Fit) -> _Told:
        """Sum up a fit, and what was believed before."""
        weights = fit.trust / (1 + fit.trust * (fit.residuals / fit.softness) ** 2)
        information = fit.jacobian.T @ (weights[:, None] * fit.jacobian) + np.diag(fit.belief)
        unit = np.sqrt(np.diag(information))
        root = np.linalg.cholesky(information / np.outer(unit, unit)).T * unit
        return cls(fit, weights, root, ALIKE * (fit.softness / 2) ** 2)

    def change(self, y: Floats) -> Floats:
        """How much the unknowns change, (u,), from y (u,)."""
        return np.asarray(np.linalg.solve(self.root, y))

    def params(self, y: Floats) -> Floats:
        """The model's parameters where y (u,) is."""
        params = self.fit.params.copy()
        params[self.fit.free] += self.change(y)[: len(self.fit.free)]
        return params

    def grown(self, y: Floats) -> Floats:
        """How much there is of each growth (g,) where y (u,) is."""
        return np.asarray(self.fit.growth + self.change(y)[len(self.fit.free) :])


@dataclass(frozen=True)
class _Near:
    """The places of lines where ``y`` (u,) is, and to first order near it: ``slopes`` (u, n, 2, 3)."""

    told: _Told
    y: Floats
    places: LinePlaces
    slopes: Floats

    @classmethod
    def of(cls, told: _Told, y: Floats, places_under: Callable[[Floats], LinePlaces]) -> _Near:
        """Sum up the lines where y is, and a standard deviation beside it each way."""
        here = places_under(told.params(y))
        step = np.sqrt(told.noise)
        beside = [places_under(told.params(y + step * way)) for way in np.eye(len(y))]
        return cls(told, y, here, np.array([(b.sums - here.sums) / step for b in beside]))

    def off(self, y: Floats, grids: _Grids) -> Floats:
        """How far the grids' lines depart from the points' own where y is, (n, 2) px times root of mass."""
        sums = self.places.sums + np.tensordot(y - self.y, self.slopes, 1)
        grown = np.append(self.told.grown(y), grids.growth)
        return replace(self.places, sums=sums).off(grids.places(), grown)


@dataclass(frozen=True)
class _Grids:
    """The pencils of each board, the ways (w, 9) in which each may move, and the lines that are theirs.

    ``numbers`` (n,) are the lines' own, those of ``open`` (m,) still to be found. ``growth`` (g,): how much
    there is of growth that the fit knows nothing of.
    """

    pencils: tuple[Pencils, ...]
    ways: tuple[Floats, ...]
    lines: Numbered
    numbers: Floats
    open: Labels
    growth: Floats

    @classmethod
    def through(cls, places: LinePlaces, lines: Numbered, reach: float, growths: int) -> _Grids:
        """Find the grids nearest to where lines run, with no growth of any of so many kinds."""
        pencils, ways = [], []
        numbers, still = np.empty(len(lines.line)), ~lines.placed
        at = np.column_stack([places.normals, -places.offsets])
        for board in range(int(lines.board.max()) + 1):
            own = np.flatnonzero(lines.board == board)
            known = lines.family[own], lines.number[own], lines.placed[own]
            grid, may_move, numbers[own] = pencils_through(at[own], *known, reach)
            pencils.append(grid)
            ways.append(may_move)
            # The first of a family without places is what the others are counted from.
            still[own[~lines.placed[own]][:1]] = False
        return cls(
            tuple(pencils), tuple(ways), lines, numbers, np.flatnonzero(still), np.zeros(growths)
        )

    @property
    def freedom(self) -> int:
        """How many numbers the grids have."""
        return sum(len(ways) for ways in self.ways) + len(self.open) + len(self.growth)

    def moved(self, steps: Floats) -> _Grids:
        """The grids moved by ``steps`` (freedom,) along their ways, and the open numbers."""
        parts = [len(ways) for ways in self.ways] + [len(self.open)]
        *each, more, growth = np.split(steps, np.cumsum(parts))
        moved = [
            replace(p, vector=p.vector + step @ ways)
            for p, ways, step in zip(self.pencils, self.ways, each, strict=True)
        ]
        numbers = self.numbers.copy()
        numbers[self.open] += more
        return replace(self, pencils=tuple(moved), numbers=numbers, growth=self.growth + growth)

    def places(self) -> Floats:
        """Where the lines run in the grids, (n, 3)."""
        found = np.empty((len(self.lines.line), 3))
        for board, pencils in enumerate(self.pencils):
            own = self.lines.board == board
            found[own] = pencils.lines(self.lines.family[own], self.numbers[own])
        return found


def _solved(near: _Near, grids: _Grids, shares: Floats) -> tuple[Floats, _Grids]:
    """The unknowns y (u,) and the grids that agree best; ``shares`` (n,) weigh the lines' places."""
    count = len(near.y)

    def misfit(x: Floats) -> Floats:
        off = near.off(x[:count], grids.moved(x[count:]))
        return np.concatenate([x[:count], (off * shares[:, None]).ravel()])

    def loss(z: Floats) -> Floats:
        """Squares for what the fit tells, Cauchy's for the lines' places."""
        rho = np.stack([z, np.ones_like(z), np.zeros_like(z)])
        wide = SOFTNESS**2 * near.told.noise
        weight = 1 / (1 + z[count:] / wide)
        rho[:, count:] = wide * np.log1p(z[count:] / wide), weight, -(weight**2) / wide
        return rho

    start = np.concatenate([near.y, np.zeros(grids.freedom)])
    # Scaled by the jacobian, of which growth to be found makes little of all else, it stops half-way.
    x = least_squares(misfit, start, method="trf", loss=loss, xtol=1e-7).x
    return x[:count], grids.moved(x[count:])


def _irregularity(near: _Near, grids: _Grids, y: Floats) -> float:
    """The standard deviation, px, by which lines lie elsewhere than noise and the grids have it.

    Uneven print moves lines aside and hardly turns them; the larger of both counts.
    """
    mass = near.places.mass
    squares = near.off(y, grids) ** 2 / mass[:, None]
    usual = MEDIAN_SQUARE * max(1 - grids.freedom / squares.size, 0.1)
    return max(_spread(square, near.told.noise / mass, usual) for square in squares.T)


def _spread(squares: Floats, noise: Floats, usual: float) -> float:
    """What standard deviation beside the variances ``noise`` (n,) makes the median of squares ``usual``."""

    def excess(variance: float) -> float:
        return float(np.median(squares / (noise + variance))) - usual

    most = float(squares.max())
    if excess(0.0) <= 0 or excess(most) >= 0:
        return 0.0 if excess(0.0) <= 0 else float(np.sqrt(most))
    return float(np.sqrt(brentq(excess, 0.0, most)))


def _places(near: _Near, grids: _Grids, shares: Floats, labels: Labels, step: int) -> Places:
    """The residuals (q,) of the lines' places beside the grids, and what moves them, as they weigh.

    What the grids explain is taken off, and what is left enlarged by how far each place pulls its grid.
    """
    count = len(near.y)

    def off(x: Floats) -> Floats:
        moved = near.off(x[:count], grids.moved(x[count:]))
        return np.asarray((moved * shares[:, None]).ravel())

    x = np.concatenate([near.y, np.zeros(grids.freedom)])
    ways = 1e-3 * np.sqrt(near.told.noise) * np.eye(len(x))
    ways[count:] *= 1e-3
    jacobian = np.stack([(off(x + s) - off(x - s)) / (2 * s.max()) for s in ways], axis=1)
    here = off(x)
    root = 1 / np.sqrt(1 + here**2 / (SOFTNESS**2 * near.told.noise))
    basis, sizes, _ = np.linalg.svd(root[:, None] * jacobian[:, count:], full_matrices=False)
    basis = basis[:, sizes > LEAST_SIZE * sizes[0]]
    own = root[:, None] * (jacobian[:, :count] @ near.told.root)
    own -= basis @ (basis.T @ own)
    left = root * here / np.sqrt(np.maximum(1 - np.sum(basis**2, axis=1), 0.1))
    # Two numbers of each line, in turn.
    row = np.full(int(labels.max()) + 1, -1)
    row[grids.lines.line] = np.arange(len(shares))
    point = np.flatnonzero(row[labels] >= 0)
    rows = 2 * row[labels[point]] + np.array([[0], [1]])
    pulls = near.places.moved[:, point] * (root * np.repeat(shares, 2))[rows]
    at = (rows.ravel(), np.tile(point, 2))
    return Places(
        left, own, csr_array((pulls.ravel(), at), shape=(len(root), len(labels))), step, basis
    )
