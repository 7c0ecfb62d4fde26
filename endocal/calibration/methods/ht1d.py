"""HT1D: the entropy of the one-dimensional, angular Hough transform (Rosten & Loveland 2011).

E. Rosten, R. Loveland, "Camera distortion self-calibration using the plumb-line constraint and minimal
Hough entropy", Machine Vision and Applications 22 (2011) 77-85, doi:10.1007/s00138-009-0196-9: edge points
vote by the undistorted direction of their edges alone, and the entropy of the normalised histogram is
minimised. Lines must share few directions, which perspective spoils.

What the article under comparison leaves open, and what is done here: the division model in the place of
Harris's, and Algorithm 1 in that of their optimiser, as it says; gradients by the same Sobel mask and
undistorted by eq. 7 as for HEwG; one vote each; a histogram of ANGLES cells over half a turn, as fine as
the angle in HEwG's map.
"""

from __future__ import annotations

import numpy as np

from ..straightness import Floats
from .entropy import entropy
from .grid import Measure, over_grid
from .tangents import Tangents

ANGLES = 180


def prepare(points: Floats, gradients: Floats, size: tuple[float, float]) -> Measure:
    """Return the measure over edge points (n, 2) px with gradients (n, 2)."""
    tangents = Tangents.of(points, gradients)

    def cost(lam: float, cx: float, cy: float) -> float:
        phi, _ = tangents.under(lam, cx, cy)
        cells = (phi * np.float32(ANGLES / np.pi)).astype(np.intp)
        votes = np.bincount(np.minimum(cells, ANGLES - 1), minlength=ANGLES)
        return entropy(votes, alone=len(points) - len(phi))

    return over_grid(cost)
