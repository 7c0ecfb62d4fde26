"""Hough entropy with the undistorted gradient, HEwG (Lee et al. 2013, eq. 2-9), over grids of models.

With d the offset of an edge point from the centre and g its unit gradient, both as complex numbers,
z = d conj(g) = D + i C, eq. 4 and 7 shorten to

    phi = phi_g + arg(1 + lam z^2)                       the direction of the line's normal
    r   = D / |1 + lam z^2|                              its distance from the centre

so that all but an arc tangent and a square root a point is shared by the models of one centre. Of g and -g
one is taken before any model (see ``Voters``), so that a line has one cell, not two.

The cells of r grow with the model's magnification over the points: of a fixed size, those of a model that
shrinks the picture gather the votes that noise has scattered, and lambda comes out some per cent too weak.

Votes are worked out in single precision. Now and then rounding moves one over a cell's border; of two models
that are nearly as good the other one may come out best then, and the search go on there, for good. So the
best ones of a grid are counted again in double precision.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from ..straightness import LEAST_DENOMINATOR, Chosen, Floats, Labels
from .settled import settled
from .tally import Tally, gains_of
from .votes import Around, Cells, Room, Voters

# The magnification is that over so many of the points, drawn evenly.
SAMPLES = 128
# Votes that are counted at once: the arrays of a block stay in a processor's cache.
BLOCK = 65_536
# What a block's models share is worked out for several blocks, up to so many numbers an array.
SHARED = 24_576
# Models are parted where they have more votes than this to count, and at least this share settled.
MANY_VOTES = 1 << 20
WORTH_PARTING = 0.1
# A vote that rounding moves to another cell, which one model in twenty has, moves the entropy by a few n-ths.
# Models within so many n-ths of the least are counted again, at most so many of them: where there are more,
# they are those of a last round, whose votes hardly differ.
ROUNDED = 10.0
MOST_AGAIN = 32


def hewg(
    voters: Voters, lams: Floats, xs: Floats, ys: Floats, chosen: Chosen | None = None
) -> Floats:
    """Return the entropy (eq. 6) for every combination: (len(lams), len(xs), len(ys)).

    ``lams`` px^-2; ``xs`` and ``ys`` the centre's coordinates, px. A point that a model cannot undistort
    votes for a cell of its own, so that entropies of different models compare. Those that are not
    ``chosen``, of the same shape, have infinity in its place.
    """
    models = _Models.of(voters, lams, xs, ys)
    room = Room(max(BLOCK, len(voters)))
    out = np.full(models.magnifications.shape, np.inf)
    gains = gains_of(len(voters))
    if chosen is None:
        _fill(out, voters, models, np.empty(0, np.int32), gains, room)
    else:
        _count_some(out, voters, models, chosen.transpose(1, 2, 0), gains, room)
    _count_best_again(out.ravel(), voters, models, gains)
    return out.transpose(2, 0, 1)


def magnification(squares: NDArray[np.floating], lams: Floats) -> Floats:
    """Return by how much models magnify lengths, (..., m), on (geometric) average over points.

    ``squares`` (..., n) are the points' squared distances from the centre, px^2; of them SAMPLES or so
    count. ``lams`` (m,) or (..., m), px^-2. The area around a point grows by (1 - lam r^2) / (1 + lam r^2)^3,
    the determinant of eq. 4's Jacobian.
    """
    some = squares[..., None, :: max(1, squares.shape[-1] // SAMPLES)]
    bent = some.astype(np.float64) * lams[..., None]
    shrunk = np.maximum(1 + bent, LEAST_DENOMINATOR)
    np.subtract(1, bent, out=bent)
    np.maximum(bent, LEAST_DENOMINATOR, out=bent)
    bent /= shrunk * shrunk * shrunk
    # The logarithm of a few points' product is as good as their logarithms, and much faster.
    n = bent.shape[-1]
    products = np.multiply.reduceat(bent, np.arange(0, n, 16), axis=-1)
    return np.asarray(np.exp(np.log(products).sum(axis=-1) / (2 * n)))


@dataclass(frozen=True)
class _Models:
    """The models of a grid: each axis, and what they magnify by, (len(xs), len(ys), len(lams))."""

    xs: Floats
    ys: Floats
    lams: Floats
    magnifications: Floats

    @classmethod
    def of(cls, voters: Voters, lams: Floats, xs: Floats, ys: Floats) -> _Models:
        some = _samples(voters)
        rows = (Around.of(some, np.full(len(ys), x), ys).square[:, 0] for x in xs)
        return cls(xs, ys, lams, np.stack([magnification(row, lams) for row in rows]))

    def about(self, chosen: Labels) -> _Models:
        """The smallest part of the grid that has all models of these numbers, lambda counted first."""
        places = np.unravel_index(chosen, self.magnifications.shape)
        return self.part(tuple(slice(int(p.min()), int(p.max()) + 1) for p in places))

    def part(self, at: tuple[slice, ...]) -> _Models:
        """Those at some places of the grid, along x, y and lam."""
        x, y, lam = at
        return _Models(self.xs[x], self.ys[y], self.lams[lam], self.magnifications[at])


def _fill(
    out: Floats, voters: Voters, models: _Models, before: Cells, gains: Floats, room: Room
) -> None:
    """Set ``out``, (len(xs), len(ys), len(lams)), given the votes in cells ``before`` of settled others."""
    sure, cells = settled(voters, models.lams, models.xs, models.ys, models.magnifications)
    before = np.concatenate([before, cells])
    share = len(cells) / len(voters)
    voters = voters.only(np.flatnonzero(~sure))
    if len(voters) * out.size > MANY_VOTES and share >= WORTH_PARTING:
        halves = [(slice(n // 2), slice(n // 2, n)) if n > 1 else (slice(n),) for n in out.shape]
        for at in product(*halves):
            _fill(out[at], voters, models.part(at), before, gains, room)
    elif len(voters):
        _count(out, voters, models, Tally(gains, before), room)
    else:
        out[...] = Tally(gains, before).entropy


def _samples(voters: Voters) -> Voters:
    """Those that tell how much a model magnifies."""
    return voters.only(slice(None, None, max(1, len(voters) // SAMPLES)))


def _count_best_again(out: Floats, voters: Voters, models: _Models, gains: Floats) -> None:
    """Set those of ``out``, a grid's entropies with lambda counted first, that are nearly the least."""
    nearly = np.flatnonzero(out <= out.min() + ROUNDED / len(voters))
    best = nearly[np.argsort(out[nearly], kind="stable")[:MOST_AGAIN]]
    out[best] = _exactly(voters, models, best, gains)


def _exactly(voters: Voters, models: _Models, chosen: Labels, gains: Floats) -> Floats:
    """The entropies (k,) of the models of these numbers, lambda counted first, in double precision."""
    x, y, lam = np.unravel_index(chosen, models.magnifications.shape)
    xs, ys, lams = models.xs[x], models.ys[y], models.lams[lam, None]
    near = models.about(chosen)
    some = Around.of(_samples(voters), xs, ys, np.float64)
    magnifications = magnification(some.square[:, 0], lams)
    sure, before = settled(voters, near.lams, near.xs, near.ys, near.magnifications)
    tally = Tally(gains, before)
    voters = voters.only(np.flatnonzero(~sure))
    if len(voters) == 0:
        return np.full(len(chosen), tally.entropy)
    out = np.empty(len(chosen))
    together = max(1, BLOCK // len(voters))
    room = Room(together * len(voters), np.float64)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for i in range(0, len(chosen), together):
            at = slice(i, i + together)
            around = Around.of(voters, xs[at], ys[at], np.float64)
            cells = around.cells(lams[at], magnifications[at], room)
            out[at] = tally.entropies(cells[:, 0], room)
    return out


def _count(out: Floats, voters: Voters, models: _Models, tally: Tally, room: Room) -> None:
    """Set ``out``, as ``_fill`` does, by the votes of ``voters`` and those that are in the tally."""
    n = len(voters)
    xs, ys = np.repeat(models.xs, len(models.ys)), np.tile(models.ys, len(models.xs))
    magnifications = models.magnifications.reshape(len(xs), -1)
    entropies = np.empty(magnifications.shape)
    # As many values of lambda to a block as go into it, or all and as many centres.
    most = max(1, BLOCK // n)
    lams = -(-len(models.lams) // -(-len(models.lams) // most))
    centers = max(1, most // len(models.lams))
    together = max(1, SHARED // n // centers) * centers
    # What has no place past a fold may well be infinite.
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for i in range(0, len(xs), together):
            around = Around.of(voters, xs[i : i + together], ys[i : i + together])
            starts = range(0, len(around.offset), centers), range(0, len(models.lams), lams)
            for j, k in product(*starts):
                part = around.some(slice(j, j + centers))
                at = slice(i + j, i + j + len(part.offset)), slice(k, k + lams)
                cells = part.cells(models.lams[at[1]], magnifications[at], room)
                found = tally.entropies(cells.reshape(-1, cells.shape[-1]), room)
                entropies[at] = found.reshape(cells.shape[:2])
    out[...] = entropies.reshape(out.shape)


def _count_some(
    out: Floats, voters: Voters, models: _Models, chosen: Chosen, gains: Floats, room: Room
) -> None:
    """Set those of ``out``, (len(xs), len(ys), len(lams)), that are ``chosen``: few, and of unlike models."""
    tally = Tally(gains, np.empty(0, np.int32))
    most = max(1, BLOCK // len(voters))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for x, y in np.argwhere(chosen.any(axis=2)):
            around = Around.of(voters, models.xs[x, None], models.ys[y, None])
            lams = np.flatnonzero(chosen[x, y])
            for i in range(0, len(lams), most):
                at = lams[i : i + most]
                cells = around.cells(models.lams[at], models.magnifications[x, y][None, at], room)
                out[x, y, at] = tally.entropies(cells[0], room)
