"""The cells that edge points vote for in HEwG's map: see ``hewg``."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..straightness import LEAST_DENOMINATOR, Floats, Labels

Single = NDArray[np.float32]
# In single precision, or in double where it matters.
Numbers = NDArray[np.floating]
Precision = type[np.floating]
Cells = NDArray[np.int32]

# Cells of the vote map: half turns over ANGLES, and px (of a 720 x 540 frame: see ``Voters.of``).
ANGLES = 180
OFFSET_STEP = 2.0
# A vote is moved by up to so many cells, to both sides: see ``Voters``.
SPREAD = 1.0
# A cell's number is its offset's times this, plus its angle's, of which there are so many.
STRIDE = 2.0 * ANGLES + 8
# Where half a turn of directions begins is looked for in steps of one of so many.
SEAMS = 36
# Past a fold each point has a cell of its own, numbered from here on: farther out than any other.
ALONE = 1 << 30
# From this bending on, |lam| r^2, a model is past its fold, or so near that a point may vote anywhere.
FOLDING = 1 - LEAST_DENOMINATOR
# As good as no lambda, px^-2, but with an inverse.
LEAST_LAMBDA = 1e-30


@dataclass(frozen=True)
class Voters:
    """Edge points (n,) ready to vote: places, px, unit gradients, and their angles in turns.

    ``step`` px is the height of a cell of the map where a model magnifies nothing. Of an edge's two normals
    the one is taken that lies in the half turn which begins where the fewest edges point: so the votes of one
    line fall on one side, and none but those of such edges are parted.

    Each point's vote is moved by an amount of its own, the same under all models: ``aside`` in cells of r,
    and by as much in angle, which ``turn`` includes. Votes that agree would else count as one cell or as two,
    by where the borders of cells happen to lie; with a few lines of one direction, parallel bars, that is as
    much as what tells models apart. So moved they spread over neighbouring cells, wherever the line lies, as
    if the map had been smoothed by a kernel two cells wide.
    """

    x: Single
    y: Single
    gx: Single
    gy: Single
    turn: Single
    aside: Single
    step: float

    def __len__(self) -> int:
        return len(self.x)

    @classmethod
    def of(
        cls, points: Floats, gradients: Floats, frame_height: float, spread: float = SPREAD
    ) -> Voters:
        """Take points (n, 2) px and gradients (n, 2); the cell grows with the frame's height, px.

        ``spread`` is the most that a vote is moved by, in cells.
        """
        angle = np.arctan2(gradients[:, 1], gradients[:, 0])
        seam = _emptiest(angle)
        angle = seam + (angle - seam) % np.pi
        # The sum of two even spreads: votes are as even as can be where they fall at random.
        moved = spread * (_even(len(points)) + _even(len(points), 1))
        return cls(
            x=points[:, 0].astype(np.float32),
            y=points[:, 1].astype(np.float32),
            gx=np.cos(angle).astype(np.float32),
            gy=np.sin(angle).astype(np.float32),
            turn=((angle + moved[:, 0] * (np.pi / ANGLES)) / (2 * np.pi)).astype(np.float32),
            aside=moved[:, 1].astype(np.float32),
            step=OFFSET_STEP * max(1.0, frame_height / 540),
        )

    def only(self, chosen: Labels | slice) -> Voters:
        """Those at some places."""
        own = (self.x, self.y, self.gx, self.gy, self.turn, self.aside)
        x, y, gx, gy, turn, aside = (v[chosen] for v in own)
        return Voters(x, y, gx, gy, turn, aside, self.step)


def _emptiest(angle: Floats) -> float:
    """The direction, from 0 to pi, about which the fewest edges point, given their angles (n,)."""
    at = np.floor(angle * (SEAMS / np.pi)).astype(np.intp) % SEAMS
    counts = np.bincount(at, minlength=SEAMS)
    around = 2 * counts + np.roll(counts, 1) + np.roll(counts, -1)
    return float((np.argmin(around) + 0.5) * np.pi / SEAMS)


def _even(count: int, seed: int = 0) -> Floats:
    """Pairs (count, 2) from -1/2 to 1/2 that fill the square evenly, in random order.

    Multiples of the inverse powers of the plastic number, the root of x^3 = x + 1.
    """
    plastic = 1.32471795724474602596
    number = np.random.default_rng(seed).permutation(count)[:, None]
    return np.asarray((number / plastic ** np.arange(1, 3)) % 1 - 0.5, np.float64)


@dataclass(frozen=True)
class Around:
    """What the models of some centres share, (centres, 1, n) each: see z in ``hewg``.

    ``offset`` is D in cells, ``real`` and ``imaginary`` are the parts of z^2 and ``square`` is |z|^2, px^2;
    ``angle`` (n,), phi_g in cells, and ``aside`` (n,) are the voters'. No point is farther out than
    ``farthest``, px^2.
    """

    offset: Numbers
    real: Numbers
    imaginary: Numbers
    square: Numbers
    angle: Numbers
    aside: Single
    farthest: float

    @classmethod
    def of(
        cls, voters: Voters, xs: Floats, ys: Floats, precision: Precision = np.float32
    ) -> Around:
        """Take the centres' coordinates, (centres,) px."""
        dx = voters.x - xs.astype(precision)[:, None, None]
        dy = voters.y - ys.astype(precision)[:, None, None]
        d = dx * voters.gx
        d += dy * voters.gy
        c = np.multiply(dy, voters.gx, out=dy)
        c -= np.multiply(dx, voters.gy, out=dx)
        imaginary = d * c
        imaginary *= 2
        offset = d * (1 / voters.step)
        d *= d
        c *= c
        square = d + c
        d -= c
        farthest = float(square.max())
        angle = voters.turn.astype(precision) * (2.0 * ANGLES)
        return cls(offset, d, imaginary, square, angle, voters.aside, farthest)

    def some(self, at: slice) -> Around:
        """Those of some of the centres."""
        return Around(
            self.offset[at],
            self.real[at],
            self.imaginary[at],
            self.square[at],
            self.angle,
            self.aside,
            self.farthest,
        )

    def cells(self, lams: Floats, magnifications: Floats, room: Room) -> Cells:
        """The number of the cell that each point votes for, (centres, m, n), in ``room``.

        ``lams`` (m,), or (centres, m) where each centre has its own, px^-2. ``magnifications`` (centres, m)
        are those of ``hewg.magnification``.
        """
        shape = (*magnifications.shape, self.offset.shape[-1])
        real, ratio, r, cells = room.numbers(shape)
        lams = np.where(np.abs(lams) < LEAST_LAMBDA, LEAST_LAMBDA, lams)
        # Each step goes over all votes, and 1 / lam + z^2 takes two steps less than 1 + lam z^2. Before a
        # fold the real part of the latter is positive, and an arc tangent of the ratio will do.
        np.add(self.real, (1 / lams).astype(real.dtype)[..., None], out=real)
        np.divide(self.imaginary, real, out=ratio)
        np.multiply(ratio, ratio, out=r)
        r += 1
        np.sqrt(r, out=r)
        r *= real
        r *= (lams * magnifications).astype(real.dtype)[:, :, None]
        np.divide(self.offset, r, out=r)
        r += self.aside
        phi = np.arctan(ratio, out=ratio)
        phi *= ANGLES / np.pi
        phi += self.angle
        np.floor(phi, out=phi)
        np.floor(r, out=r)
        r *= STRIDE
        r += phi
        np.copyto(cells, r, casting="unsafe")
        bending = np.abs(lams)
        if float(bending.max()) * self.farthest >= FOLDING:
            self._part_folded(cells, np.broadcast_to(bending, magnifications.shape))
        return cells

    def _part_folded(self, cells: Cells, bending: Floats) -> None:
        """Give each point past a model's fold a cell of its own; ``bending`` (centres, m), px^-2."""
        alone = np.arange(ALONE, ALONE + cells.shape[-1], dtype=np.int32)
        for model in np.flatnonzero(bending.max(axis=0) * self.farthest >= FOLDING):
            bent = bending[:, model, None].astype(self.square.dtype) * self.square[:, 0]
            np.copyto(cells[:, model], alone, where=bent >= FOLDING)


class Room:
    """Where the votes of a block are worked out: taken anew for each, memory would cost as much as they."""

    def __init__(self, votes: int, precision: Precision = np.float32) -> None:
        self._numbers = np.empty((3, votes), precision)
        self._flags = np.empty(votes + 1, bool)
        self._counts = np.empty(votes, np.intp)
        self._gains = np.empty(votes, np.float64)

    def numbers(self, shape: tuple[int, ...]) -> tuple[Numbers, Numbers, Numbers, Cells]:
        """Four arrays of that shape, which hold anything; the last one lies where the first does."""
        votes = math.prod(shape)
        a, b, c = self._numbers[:, :votes].reshape(3, *shape)
        return a, b, c, self._numbers[0].view(np.int32)[:votes].reshape(shape)

    def flags(self, size: int) -> NDArray[np.bool_]:
        """An array (size,) that holds anything."""
        return self._flags[:size]

    def counts(self, size: int) -> Labels:
        """An array (size,) that holds anything."""
        return self._counts[:size]

    def gains(self, size: int) -> Floats:
        """An array (size,) that holds anything."""
        return self._gains[:size]
