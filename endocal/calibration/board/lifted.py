"""The division model and the homographies of chessboards, from their corners.

A picture's coordinates are in px, a board's in squares. Melo, Barreto and Falcao 2012
(doi:10.1109/TBME.2011.2177268): with q = x^2 + y^2, eq. 4 makes a corner's place on the board a linear
function of (q, x, y, 1) up to scale, (X, Y, 1) ~ N (q, x, y, 1), N being 3 x 4. Its twelve numbers follow
from the corners by a direct linear transform, and what N maps to zero is (|c|^2 - 1 / lam, cx, cy, 1).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from ..straightness import Floats, Labels

# Residuals beyond this, px, count ever less: a corner may have been taken for another.
SOFTNESS = 0.5
# |lam| r^2 at the farthest corner is kept below this at the start.
STRONGEST = 0.95


@dataclass(frozen=True)
class Corners:
    """A board's corners: ``points`` (n, 2) px, and ``places`` (n, 2) on the board, whole numbers."""

    points: Floats
    places: Labels


@dataclass(frozen=True)
class BoardFit:
    """(lam, cx, cy), and for each board the homography from squares to undistorted offsets, px.

    ``residuals`` (n, 2) px: from where the model sees the corners of all boards to where they are.
    """

    params: Floats
    homographies: list[Floats]
    residuals: Floats


def see(params: Floats, homography: Floats, places: Floats | Labels) -> Floats:
    """Return where places (n, 2) on a board are seen, (n, 2) px; NaN where the model has no such place."""
    h = np.column_stack([places, np.ones(len(places))]) @ homography.T
    with np.errstate(divide="ignore", invalid="ignore"):
        u = h[:, :2] / h[:, 2:]
        ratio = 2 / (1 + np.sqrt(1 - 4 * params[0] * np.einsum("ij,ij->i", u, u)))
    return np.asarray(params[1:3] + u * ratio[:, None])


def linear_solution(corners: Corners) -> Floats:
    """Return (lam, cx, cy) by the direct linear transform in lifted coordinates.

    The values may be absurd where the corners are few or noisy.
    """
    (x, y), to_picture = _normalized(corners.points)
    (px, py), _ = _normalized(corners.places)
    lifted = np.stack([x * x + y * y, x, y, np.ones_like(x)], axis=1)
    nothing = np.zeros_like(lifted)
    rows = [
        np.hstack([lifted, nothing, -px[:, None] * lifted]),
        np.hstack([nothing, lifted, -py[:, None] * lifted]),
    ]
    n = np.linalg.svd(np.concatenate(rows))[2][-1].reshape(3, 4)
    v = np.linalg.svd(n)[2][-1]
    # What N maps to zero is (|c|^2 - 1 / lam, cx, cy, 1), up to its scale.
    with np.errstate(divide="ignore", invalid="ignore"):
        cx, cy = v[1:3] / v[3]
        lam = 1 / (cx * cx + cy * cy - v[0] / v[3])
    unit = to_picture[0, 0]
    center = to_picture[:2, :2] @ (cx, cy) + to_picture[:2, 2]
    return np.array([lam / unit**2, *center])


def fit(
    boards: Sequence[Corners], start: Floats, center_is_given: bool = False, rounds: int = 50
) -> BoardFit:
    """Fit (lam, cx, cy) and a homography a board, by the distances of corners in the picture, px.

    It starts at ``start``, whose centre it keeps where ``center_is_given``. At least 6 corners a board.
    """
    first = start.copy()
    reach = max(float(np.linalg.norm(b.points - start[1:3], axis=1).max()) for b in boards)
    first[0] = np.clip(first[0], -STRONGEST / reach**2, STRONGEST / reach**2)
    unit = np.array([0.1 / reach**2, 0.05 * reach, 0.05 * reach])[: 1 if center_is_given else 3]
    scaled = [_normalized(b.places)[1] for b in boards]
    begin = [_homography(b, first) @ s for b, s in zip(boards, scaled, strict=True)]

    def unpack(x: Floats) -> tuple[Floats, list[Floats]]:
        params = first.copy()
        params[: len(unit)] += x[: len(unit)] * unit
        changes = x[len(unit) :].reshape(len(boards), 3, 3)
        # Columns in their own size: the last row's are 1 / px times those of the others.
        size = np.array([[reach], [reach], [1.0]]) * 0.01
        parts = zip(begin, changes, scaled, strict=True)
        return params, [(h + size * c) @ np.linalg.inv(s) for h, c, s in parts]

    def misfit(x: Floats) -> Floats:
        params, homographies = unpack(x)
        seen = [see(params, h, b.places) for h, b in zip(homographies, boards, strict=True)]
        off = np.concatenate([s - b.points for s, b in zip(seen, boards, strict=True)])
        # A board that a trial step tears off the plane is as wrong as can be, not undefined.
        return np.nan_to_num(off, nan=10 * reach).ravel()

    x = np.zeros(len(unit) + 9 * len(boards))
    solution = least_squares(
        misfit, x, loss="cauchy", f_scale=SOFTNESS, x_scale="jac", max_nfev=rounds
    )
    params, homographies = unpack(solution.x)
    return BoardFit(params, homographies, misfit(solution.x).reshape(-1, 2))


def _homography(corners: Corners, params: Floats) -> Floats:
    """The homography from squares to undistorted offsets, by a direct linear transform."""
    d = corners.points - params[1:3]
    u = d / (1 + params[0] * np.einsum("ij,ij->i", d, d))[:, None]
    (x, y), to_picture = _normalized(u)
    (px, py), to_board = _normalized(corners.places)
    place = np.stack([px, py, np.ones_like(px)], axis=1)
    nothing = np.zeros_like(place)
    rows = [
        np.hstack([place, nothing, -x[:, None] * place]),
        np.hstack([nothing, place, -y[:, None] * place]),
    ]
    h = to_picture @ np.linalg.svd(np.concatenate(rows))[2][-1].reshape(3, 3)
    h = h @ np.linalg.inv(to_board)
    return np.asarray(h / np.abs(h[2]).max())


def _normalized(points: Floats | Labels) -> tuple[Floats, Floats]:
    """Coordinates (2, n) around 0 and of size 1, and the matrix (3, 3) that brings them back."""
    middle = points.mean(axis=0)
    size = float(np.abs(points - middle).max())
    back = np.array([[size, 0, middle[0]], [0, size, middle[1]], [0, 0, 1]])
    return ((points - middle) / size).T, back
