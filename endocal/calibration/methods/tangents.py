"""The straight line along each edge point, as a model sees it: the vote of eq. 8 and 9, not yet counted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..straightness import LEAST_DENOMINATOR, Floats

Single = NDArray[np.float32]


@dataclass(frozen=True)
class Tangents:
    """Edge points (n,) px with the angles and parts of their unit gradients (n,)."""

    x: Single
    y: Single
    gx: Single
    gy: Single
    angle: Single

    @classmethod
    def of(cls, points: Floats, gradients: Floats) -> Tangents:
        """Take points (n, 2) px and gradients (n, 2) of any length."""
        g = gradients / np.maximum(np.linalg.norm(gradients, axis=1), 1e-12)[:, None]
        x, y, gx, gy = (v.astype(np.float32) for v in (*points.T, *g.T))
        return cls(x, y, gx, gy, np.arctan2(gy, gx))

    def under(self, lam: float, cx: float, cy: float) -> tuple[Single, Single]:
        """Return the undistorted lines' normals, as angles in [0, pi), and offsets from the centre, px.

        (n,) each; points past the model's fold are left out. With z = d conj(g), d the offset from the
        centre, eq. 4 and 7 give the angle of g plus that of 1 + lam z^2, and Re z / |1 + lam z^2|.
        """
        dx, dy = self.x - np.float32(cx), self.y - np.float32(cy)
        along, across = dx * self.gx + dy * self.gy, dy * self.gx - dx * self.gy
        angle = self.angle
        if lam < 0:
            held = dx * dx + dy * dy < (1 - LEAST_DENOMINATOR) / -np.float32(lam)
            along, across, angle = along[held], across[held], angle[held]
        real = 1 + np.float32(lam) * (along * along - across * across)
        imaginary = np.float32(2 * lam) * along * across
        turns = (angle + np.arctan2(imaginary, real)) / np.float32(np.pi)
        half = np.floor(turns)
        # A normal turned by half a turn has the opposite offset.
        offset = along / np.hypot(real, imaginary) * (1 - 2 * np.abs(half % 2))
        phi = np.minimum((turns - half) * np.float32(np.pi), np.float32(np.nextafter(3.1415927, 0)))
        return phi, offset
