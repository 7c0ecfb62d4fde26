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

from ..board.lattice import numbers_of
from ..board.pattern import crossings_of
from ..board.pencils import Pencils, pencils_through
from ..measure.growth import growth_columns
from ..measure.profiles import Measured
from ..straightness import Floats, Labels
from .line_places import LinePlaces
from .plumb_line import ALIKE, Fit

# A board's grid is looked for where so many of its rows and so many of its columns are numbered.
FEWEST_NUMBERED = 4
# Of all points so many tell where the lines run.
ENOUGH_POINTS = 4000
# Rounds in which the lines' places, and how irregular the boards are, are found anew; till that changes by
# less than SETTLED px.
ROUNDS = 4
SETTLED = 1e-3
# A line farther from its place than so many standard deviations counts ever less (Cauchy): its number may be
# wrong.
SOFTNESS = 4.0
# Half of all squares of normal deviates are smaller than this.
MEDIAN_SQUARE = 0.455


@dataclass(frozen=True)
class Numbered:
    """Lines that are known on a board: their labels ``line`` (n,), ``board``, ``family`` and ``number``."""

    line: Labels
    board: Labels
    family: Labels
    number: Labels


def numbered_lines(measured: Measured, view: Labels) -> Numbered:
    """Return the lines that the crossings of each view number, where a view shows enough of them.

    ``view`` (n,) tells which view each point is from. Boards are numbered from 0.
    """
    parts: list[tuple[Labels, ...]] = []
    for own in (view == v for v in np.unique(view)):
        lines = np.unique(measured.labels[own])
        family, number = numbers_of(crossings_of(measured.take(own)), len(lines))
        if min(np.count_nonzero(family == f) for f in (0, 1)) >= FEWEST_NUMBERED:
            known = family >= 0
            board = np.full(np.count_nonzero(known), len(parts))
            parts.append((lines[known], board, family[known], number[known]))
    if not parts:
        return Numbered(*(np.empty(0, np.intp),) * 4)
    return Numbered(*(np.concatenate(p).astype(np.intp) for p in zip(*parts, strict=True)))


def fit_grid(measured: Measured, view: Labels, fit: Fit, reach: float) -> Fit | None:
    """Fit the model of ``fit``, and a grid for each board, to lines that are measured and fitted already.

    What straightness tells of the model and of growth is summed up by the information of ``fit`` about its
    answer. ``view`` (n,): which view each point is from; ``reach`` px: how far the points go. Returns a fit
    that rests on the lines' places, too; None where no board's lines are numbered.
    """
    lines = numbered_lines(measured, view)
    at_a_bound = not fit.jacobian[:, : len(fit.free)].any(axis=0).all()
    if len(lines.line) == 0 or at_a_bound:
        return None
    told = _Told.by(fit)
    columns = growth_columns(measured.sides, measured.levels, measured.labels)
    step = max(1, len(measured.points) // ENOUGH_POINTS)
    few = measured.in_order(np.arange(0, len(measured.points), step), measured.labels[::step])
    weights = step * told.weights[::step]

    def places_under(params: Floats) -> LinePlaces:
        return LinePlaces.of(few, lines.line, params, weights, columns[::step])

    near = _Near.of(told, np.zeros(len(told.root)), places_under)
    grids = _Grids.through(near.places, lines, reach)
    y, irregular = near.y, 0.0
    for _ in range(ROUNDS):
        shares = 1 / np.sqrt(1 + near.places.mass * irregular**2 / told.noise)
        y, grids = _solved(near, grids, shares)
        before, irregular = irregular, _irregularity(near, grids, y)
        near = _Near.of(told, y, places_under)
        if abs(irregular - before) < SETTLED:
            break
    return _as_fit(fit, near, grids, shares)


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

    def off(self, y: Floats, lines: Floats) -> Floats:
        """How far ``lines`` (n, 3) depart from the points' own where y is, (n, 2) px times root of mass."""
        sums = self.places.sums + np.tensordot(y - self.y, self.slopes, 1)
        return replace(self.places, sums=sums).off(lines, self.told.grown(y))


@dataclass(frozen=True)
class _Grids:
    """The pencils of each board, the ways (8, 9) in which they may move, and the lines that are theirs."""

    pencils: tuple[Pencils, ...]
    ways: tuple[Floats, ...]
    lines: Numbered

    @classmethod
    def through(cls, places: LinePlaces, lines: Numbered, reach: float) -> _Grids:
        """Find the grids nearest to where lines run."""
        found = []
        for board in range(int(lines.board.max()) + 1):
            own = lines.board == board
            numbers = lines.family[own], lines.number[own]
            found.append(pencils_through(places.normals[own], places.offsets[own], *numbers, reach))
        pencils, ways = zip(*found, strict=True)
        return cls(pencils, ways, lines)

    @property
    def freedom(self) -> int:
        """How many numbers the grids have."""
        return sum(len(ways) for ways in self.ways)

    def moved(self, steps: Floats) -> _Grids:
        """The grids moved by ``steps`` (freedom,) along their ways."""
        each = np.split(steps, np.cumsum([len(ways) for ways in self.ways])[:-1])
        moved = [
            replace(p, vector=p.vector + step @ ways)
            for p, ways, step in zip(self.pencils, self.ways, each, strict=True)
        ]
        return replace(self, pencils=tuple(moved))

    def places(self) -> Floats:
        """Where the lines run in the grids, (n, 3)."""
        found = np.empty((len(self.lines.line), 3))
        for board, pencils in enumerate(self.pencils):
            own = self.lines.board == board
            found[own] = pencils.lines(self.lines.family[own], self.lines.number[own])
        return found


def _solved(near: _Near, grids: _Grids, shares: Floats) -> tuple[Floats, _Grids]:
    """The unknowns y (u,) and the grids that agree best; ``shares`` (n,) weigh the lines' places."""
    count = len(near.y)

    def misfit(x: Floats) -> Floats:
        off = near.off(x[:count], grids.moved(x[count:]).places())
        return np.concatenate([x[:count], (off * shares[:, None]).ravel()])

    def loss(z: Floats) -> Floats:
        """Squares for what the fit tells, Cauchy's for the lines' places."""
        rho = np.stack([z, np.ones_like(z), np.zeros_like(z)])
        wide = SOFTNESS**2 * near.told.noise
        weight = 1 / (1 + z[count:] / wide)
        rho[:, count:] = wide * np.log1p(z[count:] / wide), weight, -(weight**2) / wide
        return rho

    start = np.concatenate([near.y, np.zeros(grids.freedom)])
    x = least_squares(misfit, start, method="trf", loss=loss, x_scale="jac", xtol=1e-7).x
    return x[:count], grids.moved(x[count:])


def _irregularity(near: _Near, grids: _Grids, y: Floats) -> float:
    """The standard deviation, px, by which lines lie elsewhere than noise and the grids have it."""
    mass = np.repeat(near.places.mass, 2)
    square = near.off(y, grids.places()).ravel() ** 2 / mass
    usual = MEDIAN_SQUARE * max(1 - grids.freedom / len(square), 0.1)

    def excess(variance: float) -> float:
        return float(np.median(square / (near.told.noise / mass + variance))) - usual

    most = float(square.max())
    if excess(0.0) <= 0 or excess(most) >= 0:
        return 0.0 if excess(0.0) <= 0 else float(np.sqrt(most))
    return float(np.sqrt(brentq(excess, 0.0, most)))


def _as_fit(fit: Fit, near: _Near, grids: _Grids, shares: Floats) -> Fit:
    """The whole as one fit, the lines' places weighed as their distances from the grids tell."""
    told, count = near.told, len(near.y)

    def off(x: Floats) -> Floats:
        moved = near.off(x[:count], grids.moved(x[count:]).places())
        return np.asarray((moved * shares[:, None]).ravel())

    x = np.concatenate([near.y, np.zeros(grids.freedom)])
    step = 1e-3 * np.sqrt(told.noise) * np.eye(len(x))
    step[count:] *= 1e-3
    jacobian = np.stack([(off(x + s) - off(x - s)) / (2 * s.max()) for s in step], axis=1)
    here = off(x)
    root = 1 / np.sqrt(1 + here**2 / (SOFTNESS**2 * told.noise))
    # What the grids explain is taken off, and what is left enlarged by how far each place pulls its grid.
    basis, _ = np.linalg.qr(root[:, None] * jacobian[:, count:])
    own = root[:, None] * (jacobian[:, :count] @ told.root)
    own -= basis @ (basis.T @ own)
    here = root * here / np.sqrt(np.maximum(1 - np.sum(basis**2, axis=1), 0.1))
    return replace(
        fit,
        params=told.params(near.y),
        residuals=fit.residuals + fit.jacobian @ told.change(near.y),
        growth=told.grown(near.y),
        places=(here, own),
    )
