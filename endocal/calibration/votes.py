"""The cells that edge points vote for in HEwG's map, and the entropy of their votes: see ``hough``."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .straightness import LEAST_DENOMINATOR, Floats, Labels

Single = NDArray[np.float32]
Cells = NDArray[np.int32]

# Cells of the vote map: half turns over ANGLES, and px (of a 720 x 540 frame: see ``Voters.of``).
ANGLES = 180
OFFSET_STEP = 2.0
# A cell's number is its offset's times this, plus its angle's, which rounding may make a whole turn.
STRIDE = np.float32(2 * ANGLES + 1)
# Past a fold each point has a cell of its own, numbered from here on: farther out than any other.
ALONE = 1 << 30
# From this bending on, |lam| r^2, a model is past its fold, or so near that a point may vote anywhere.
FOLDING = 1 - LEAST_DENOMINATOR
ONE, TURNS, ANGLES_OF_A_TURN = np.float32(1), np.float32(0.5 / np.pi), np.float32(2 * ANGLES)


@dataclass(frozen=True)
class Voters:
    """Edge points (n,) ready to vote: places, px, unit gradients, and their angles in [0, 1/2) turns.

    ``step`` px is the height of a cell of the map where a model magnifies nothing.
    """

    x: Single
    y: Single
    gx: Single
    gy: Single
    turn: Single
    step: float

    def __len__(self) -> int:
        return len(self.x)

    @classmethod
    def of(cls, points: Floats, gradients: Floats, frame_height: float) -> Voters:
        """Take points (n, 2) px and gradients (n, 2); the cell grows with the frame's height, px."""
        sign = np.where(
            (gradients[:, 1] < 0) | ((gradients[:, 1] == 0) & (gradients[:, 0] < 0)), -1, 1
        )
        g = gradients * (sign / np.maximum(np.linalg.norm(gradients, axis=1), 1e-12))[:, None]
        return cls(
            x=points[:, 0].astype(np.float32),
            y=points[:, 1].astype(np.float32),
            gx=g[:, 0].astype(np.float32),
            gy=g[:, 1].astype(np.float32),
            turn=np.arctan2(g[:, 1], g[:, 0]).astype(np.float32) * TURNS,
            step=OFFSET_STEP * max(1.0, frame_height / 540),
        )

    def only(self, chosen: Labels | slice) -> Voters:
        """Those at some places."""
        x, y, gx, gy, turn = (v[chosen] for v in (self.x, self.y, self.gx, self.gy, self.turn))
        return Voters(x, y, gx, gy, turn, self.step)


@dataclass(frozen=True)
class Around:
    """What the models of some centres share, (centres, 1, n) each: see z in ``hough``.

    ``offset`` is D in cells, ``real`` and ``imaginary`` are the parts of z^2 and ``square`` is |z|^2, px^2;
    ``turn`` is phi_g in turns. No point is farther out than ``farthest``, px^2.
    """

    offset: Single
    real: Single
    imaginary: Single
    square: Single
    turn: Single
    farthest: float

    @classmethod
    def of(cls, voters: Voters, xs: Floats, ys: Floats) -> Around:
        """Take the centres' coordinates, (centres,) px."""
        dx = voters.x - xs.astype(np.float32)[:, None, None]
        dy = voters.y - ys.astype(np.float32)[:, None, None]
        d = dx * voters.gx
        d += dy * voters.gy
        c = np.multiply(dy, voters.gx, out=dy)
        c -= np.multiply(dx, voters.gy, out=dx)
        turn = np.multiply(d < 0, np.float32(0.5))
        turn += voters.turn
        imaginary = d * c
        imaginary *= np.float32(2)
        offset = np.abs(d)
        offset *= np.float32(1 / voters.step)
        d *= d
        c *= c
        square = d + c
        d -= c
        return cls(offset, d, imaginary, square, turn, float(square.max()))

    def some(self, at: slice) -> Around:
        """Those of some of the centres."""
        return Around(
            self.offset[at],
            self.real[at],
            self.imaginary[at],
            self.square[at],
            self.turn[at],
            self.farthest,
        )

    def cells(self, lams: Floats, magnifications: Floats, room: Room) -> Cells:
        """The number of the cell that each point votes for, (centres, len(lams), n), in ``room``.

        ``magnifications`` (centres, len(lams)) are those of ``hough.magnification``.
        """
        shape = (len(self.offset), len(lams), self.offset.shape[-1])
        real, ratio, r = room.numbers(shape)
        column = lams.astype(np.float32)[:, None]
        # Before a fold the real part of 1 + lam z^2 is positive, and an arc tangent of the ratio will do.
        np.multiply(self.real, column, out=real)
        real += ONE
        np.multiply(self.imaginary, column, out=ratio)
        ratio /= real
        np.multiply(ratio, ratio, out=r)
        r += ONE
        np.sqrt(r, out=r)
        r *= real
        r *= magnifications.astype(np.float32)[:, :, None]
        np.divide(self.offset, r, out=r)
        phi = np.arctan(ratio, out=ratio)
        phi *= TURNS
        phi += self.turn
        phi -= np.floor(phi, out=real)
        phi *= ANGLES_OF_A_TURN
        np.floor(phi, out=phi)
        np.floor(r, out=r)
        r *= STRIDE
        r += phi
        cells = real.view(np.int32)
        np.copyto(cells, r, casting="unsafe")
        bending = np.abs(column)
        if float(bending.max()) * self.farthest >= FOLDING:
            past = bending * self.square >= FOLDING
            np.copyto(cells, np.arange(ALONE, ALONE + shape[-1], dtype=np.int32), where=past)
        return cells


class Room:
    """Where the votes of a block are worked out: taken anew for each, memory would cost as much as they."""

    def __init__(self, votes: int) -> None:
        self._numbers = np.empty((3, votes), np.float32)
        self._flags = np.empty(votes + 1, bool)
        self._counts = np.empty(votes, np.intp)
        self._gains = np.empty(votes, np.float64)

    def numbers(self, shape: tuple[int, ...]) -> tuple[Single, Single, Single]:
        """Three arrays of that shape, which hold anything."""
        a, b, c = self._numbers[:, : int(np.prod(shape))].reshape(3, *shape)
        return a, b, c

    def flags(self, size: int) -> NDArray[np.bool_]:
        """An array (size,) that holds anything."""
        return self._flags[:size]

    def counts(self, size: int) -> Labels:
        """An array (size,) that holds anything."""
        return self._counts[:size]

    def gains(self, size: int) -> Floats:
        """An array (size,) that holds anything."""
        return self._gains[:size]
