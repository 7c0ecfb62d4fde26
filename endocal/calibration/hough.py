"""Hough entropy with the undistorted gradient, HEwG (Lee et al. 2013, eq. 2-9), over grids of models.

With d the offset of an edge point from the centre and g its unit gradient, both as complex numbers,
z = d conj(g) = D + i C, eq. 4 and 7 shorten to

    phi = phi_g + arg(1 + lam z^2)                       the direction of the line's normal
    r   = D / |1 + lam z^2|                              its distance from the centre

so that all but an arc tangent and a square root a point is shared by the models of one centre. D is made
positive by turning g, and phi taken over the whole turn: a line has one cell, not two.

The cells of r grow with the model's magnification over the points: of a fixed size, those of a model that
shrinks the picture gather the votes that noise has scattered, and lambda comes out some per cent too weak.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .straightness import LEAST_DENOMINATOR, Floats

Single = NDArray[np.float32]

# Cells of the vote map: half turns over ANGLES, and px (of a 720 x 540 frame: see ``Voters.of``).
ANGLES = 180
OFFSET_STEP = 2.0
# A cell's number is its angle's times this, plus its offset's: a whole number that float32 still holds.
OFFSETS = 32768
# The magnification is that over so many of the points, drawn evenly.
SAMPLES = 128
# Votes that are counted at once: the arrays of a block stay in a processor's cache.
BLOCK = 65_536


@dataclass(frozen=True)
class Voters:
    """Edge points (n,) ready to vote: places, unit gradients with angles in [0, pi), the cell of r."""

    x: Single
    y: Single
    gx: Single
    gy: Single
    angle: Single
    reach: float
    step: float

    @classmethod
    def of(cls, points: Floats, gradients: Floats, frame_height: float) -> Voters:
        """Take points (n, 2) px and gradients (n, 2); the cell grows with the frame's height, px."""
        sign = np.where(
            (gradients[:, 1] < 0) | ((gradients[:, 1] == 0) & (gradients[:, 0] < 0)), -1, 1
        )
        g = gradients * (sign / np.maximum(np.linalg.norm(gradients, axis=1), 1e-12))[:, None]
        middle = (points.max(axis=0) + points.min(axis=0)) / 2
        return cls(
            x=points[:, 0].astype(np.float32),
            y=points[:, 1].astype(np.float32),
            gx=g[:, 0].astype(np.float32),
            gy=g[:, 1].astype(np.float32),
            angle=np.arctan2(g[:, 1], g[:, 0]).astype(np.float32),
            reach=float(np.linalg.norm(points - middle, axis=1).max()),
            step=OFFSET_STEP * max(1.0, frame_height / 540),
        )

    def __len__(self) -> int:
        return len(self.x)


def hewg(voters: Voters, lams: Floats, xs: Floats, ys: Floats) -> Floats:
    """Return the entropy (eq. 6) for every combination: (len(lams), len(xs), len(ys)).

    ``lams`` px^-2; ``xs`` and ``ys`` the centre's coordinates, px. A point that a model cannot undistort
    votes for a cell of its own, so that entropies of different models compare.
    """
    out = np.empty((len(lams), len(xs), len(ys)))
    n = len(voters)
    counts = np.arange(n + 1)
    gains = counts * np.log(np.maximum(counts, 1)) / n
    block = max(1, BLOCK // n)
    for i, cx in enumerate(xs):
        for j, cy in enumerate(ys):
            around = _Around.of(voters, cx, cy)
            for k in range(0, len(lams), block):
                # What has no place past a fold may well be infinite.
                with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
                    cells = around.cells(lams[k : k + block])
                out[k : k + block, i, j] = _entropies(cells, gains)
    return out


def magnification(squares: NDArray[np.floating], lams: Floats) -> Floats:
    """Return by how much models magnify lengths, (len(lams),), on (geometric) average over points.

    ``squares`` (n,) are the points' squared distances from the centre, px^2; of them SAMPLES or so count. The
    area around a point grows by (1 - lam r^2) / (1 + lam r^2)^3, the determinant of eq. 4's Jacobian.
    """
    bent = np.multiply.outer(lams, squares[:: max(1, len(squares) // SAMPLES)].astype(np.float64))
    apart = np.log(np.maximum(1 - bent, LEAST_DENOMINATOR))
    return np.asarray(
        np.exp((apart - 3 * np.log(np.maximum(1 + bent, LEAST_DENOMINATOR))).mean(axis=1) / 2)
    )


@dataclass(frozen=True)
class _Around:
    """What the models of one centre share, (n,) each: see the module's z; ``turn`` is phi_g in turns.

    ``offset`` is D in cells, ``real`` and ``imaginary`` are the parts of z^2 and ``square`` is |z|^2, px^2.
    """

    offset: Single
    real: Single
    imaginary: Single
    square: Single
    turn: Single

    @classmethod
    def of(cls, voters: Voters, cx: float, cy: float) -> _Around:
        dx, dy = voters.x - np.float32(cx), voters.y - np.float32(cy)
        d = dx * voters.gx + dy * voters.gy
        c = dy * voters.gx - dx * voters.gy
        return cls(
            offset=np.abs(d) * np.float32(1 / voters.step),
            real=d * d - c * c,
            imaginary=d * c * np.float32(2),
            square=d * d + c * c,
            turn=voters.angle * np.float32(0.5 / np.pi)
            + np.where(d < 0, np.float32(0.5), np.float32(0)),
        )

    def cells(self, lams: Floats) -> Single:
        """The number of the cell that each point votes for, (len(lams), n); NaN, no cell, past a fold."""
        column = lams.astype(np.float32)[:, None]
        # Before a fold the real part of 1 + lam z^2 is positive, and an arc tangent of the ratio will do.
        real = self.real * column
        real += np.float32(1)
        ratio = self.imaginary * column
        ratio /= real
        r = ratio * ratio
        r += np.float32(1)
        np.sqrt(r, out=r)
        r *= real
        r *= magnification(self.square, lams).astype(np.float32)[:, None]
        np.divide(self.offset, r, out=r)
        phi = np.arctan(ratio, out=ratio)
        phi *= np.float32(0.5 / np.pi)
        phi += self.turn
        phi -= np.floor(phi, out=real)
        phi *= np.float32(2 * ANGLES)
        cell = np.floor(phi, out=phi)
        cell *= np.float32(OFFSETS)
        cell += np.floor(r, out=r)
        folding = np.float32(1 - LEAST_DENOMINATOR)
        if np.abs(column).max() * self.square.max() >= folding:
            cell[np.abs(column) * self.square >= folding] = np.nan
        return cell


def _entropies(cells: Single, gains: Floats) -> Floats:
    """The entropy of each row of cells (m, n), which it sorts; ``gains`` (n + 1,) is c ln c / n by c votes.

    Sorting brings the votes for one cell together; it is faster than counting in a map that is mostly
    empty. NaN differs from NaN, so that the points without a cell stay apart.
    """
    m, n = cells.shape
    cells.sort(axis=1)
    first = np.ones((m, n), bool)
    np.not_equal(cells[:, 1:], cells[:, :-1], out=first[:, 1:])
    starts = np.flatnonzero(first)
    votes = np.diff(starts, append=m * n)
    rows = np.searchsorted(starts, np.arange(m) * n)
    entropies: Floats = np.log(n) - np.add.reduceat(gains.take(votes), rows)
    return entropies
