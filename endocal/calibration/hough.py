"""Hough entropy with the undistorted gradient, HEwG (Lee et al. 2013, eq. 2-9), over grids of models.

With d the offset of an edge point from the centre, g its unit gradient, D = d . g, C = d_y g_x - d_x g_y
and b = 1 + lam |d|^2, eq. 4 and 7 shorten to

    r   = D / sqrt(b^2 - 4 lam C^2)                      the line's distance from the centre
    phi = phi_g + atan2(2 lam C D, b - 2 lam C^2)        the direction of its normal

so that all but two square roots and an arc tangent a point is shared by the models of one centre.
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
# Offsets beyond this multiple of the points' own reach, and points past the fold, vote for no shared cell.
FARTHEST = 4.0


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
    columns = 2 * int(np.ceil(FARTHEST * voters.reach / voters.step)) + 2
    log_counts = np.log(np.maximum(np.arange(n + 1), 1)).astype(np.float32)
    work = _Workspace(n)
    for i, cx in enumerate(xs):
        dx = voters.x - np.float32(cx)
        for j, cy in enumerate(ys):
            dy = voters.y - np.float32(cy)
            work.prepare(voters, dx, dy)
            for k, lam in enumerate(lams):
                cells = work.cells(voters, float(lam), columns)
                votes = np.bincount(cells, minlength=ANGLES * columns + 1)
                # The last cell gathers the points that vote alone: as many cells of one vote.
                votes[-1] = 1
                out[k, i, j] = np.log(n) - float(log_counts.take(votes.take(cells)).sum()) / n
    return out


class _Workspace:
    """Arrays that every model needs, made once: memory traffic is most of the cost."""

    def __init__(self, n: int) -> None:
        self.q, self.c2, self.cd, self.d = (np.empty(n, np.float32) for _ in range(4))
        self.b, self.t, self.r, self.phi = (np.empty(n, np.float32) for _ in range(4))
        self.cell, self.column = np.empty(n, np.int32), np.empty(n, np.int32)

    def prepare(self, voters: Voters, dx: Single, dy: Single) -> None:
        """What the models of one centre share."""
        np.multiply(dx, dx, out=self.q)
        self.q += dy * dy
        np.multiply(dx, voters.gx, out=self.d)
        self.d += dy * voters.gy
        c = dy * voters.gx
        c -= dx * voters.gy
        np.multiply(c, c, out=self.c2)
        np.multiply(c, self.d, out=self.cd)

    def cells(self, voters: Voters, lam: float, columns: int) -> NDArray[np.int32]:
        """The cell (n,) that each point votes for; ANGLES * columns for none."""
        b, t, r, phi = self.b, self.t, self.r, self.phi
        np.multiply(self.q, np.float32(lam), out=b)
        b += np.float32(1)
        np.multiply(self.c2, np.float32(-4 * lam), out=t)
        np.multiply(b, b, out=r)
        r += t
        np.sqrt(r, out=r)
        np.divide(self.d, r, out=r)
        t *= np.float32(0.5)
        t += b
        np.multiply(self.cd, np.float32(2 * lam), out=phi)
        np.arctan2(phi, t, out=phi)
        phi += voters.angle
        phi *= np.float32(1 / np.pi)
        # A normal turned by half a turn has the opposite offset; turns lie in [-1, 2), so t is -1, 0 or 1.
        np.floor(phi, out=t)
        phi -= t
        np.abs(t, out=t)
        t *= np.float32(-2 / voters.step)
        t += np.float32(1 / voters.step)
        r *= t
        r += np.float32(columns / 2)
        phi *= np.float32(ANGLES)
        np.minimum(phi, np.float32(ANGLES - 1), out=phi)
        np.copyto(self.cell, phi, casting="unsafe")
        self.cell *= np.int32(columns)
        np.copyto(self.column, r, casting="unsafe")
        self.cell += self.column
        alone = (r < 0) | (r >= columns)
        if lam < 0:
            alone |= b <= np.float32(LEAST_DENOMINATOR)
        self.cell[np.flatnonzero(alone)] = ANGLES * columns
        return self.cell
