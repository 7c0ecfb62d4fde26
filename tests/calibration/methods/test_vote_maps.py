"""Vote maps of points on straight lines: sharp under the lens's own model, smeared under none."""

from __future__ import annotations

import numpy as np

from endocal.calibration.methods.entropy import entropy
from endocal.calibration.methods.vote_maps import ANGLES, vote_maps
from endocal.model import DivisionModel

SIZE = (720.0, 540.0)
MODEL = DivisionModel(-4e-6, (365.0, 266.0), (720, 540))
PARAMS = np.array([MODEL.lam, *MODEL.center])
STRAIGHT = np.array([0.0, *MODEL.center])
# All lines of the fan meet here, in the undistorted picture.
MEETING = np.array([1900.0, 700.0])


def fan() -> tuple[np.ndarray, np.ndarray]:
    """Distorted points (n, 2) of lines through MEETING, with their gradients (n, 2)."""
    points, gradients = [], []
    for y in np.linspace(-100, 600, 12):
        start = np.array([-100.0, y])
        along = (MEETING - start) / np.linalg.norm(MEETING - start)
        straight = start + np.linspace(0, 900, 400)[:, None] * along
        normal = np.broadcast_to([-along[1], along[0]], straight.shape)
        bent = MODEL.distort(straight)
        inside = (bent > 5).all(axis=1) & (bent < np.array(SIZE) - 5).all(axis=1)
        points.append(bent[inside])
        # The gradient of a pushed-back line: the transposed Jacobian times its normal.
        gradients.append(np.einsum("nji,nj->ni", MODEL.jacobian(bent), normal)[inside])
    return np.concatenate(points), np.concatenate(gradients)


def test_the_first_map_has_one_cell_or_two_a_line_under_the_model() -> None:
    points, gradients = fan()
    own = vote_maps(points, gradients, PARAMS, SIZE)
    bent = vote_maps(points, gradients, STRAIGHT, SIZE)
    assert own.first.sum() > 0.97 * len(points)
    # 12 lines; one may lie on the border of two cells, or of four.
    assert np.count_nonzero(own.first > 5) <= 4 * 12
    assert entropy(own.first) < entropy(bent.first) - 1


def test_all_lines_of_a_fan_meet_in_one_cell_of_the_second_map() -> None:
    points, gradients = fan()
    own = vote_maps(points, gradients, PARAMS, SIZE)
    # V is MEETING where M, through the top left pixel, goes there: w is the direction of M's normal, and
    # rho that of the normal of the line from the middle Q to V (eq. 10-14).
    omega = np.arctan2(MEETING[0], -MEETING[1]) % np.pi
    middle = (np.array(SIZE) - 1) / 2
    # n = Q x V in homogeneous coordinates; rho = atan2(n1, n2).
    n = np.cross([*middle, 1.0], [*MEETING, 1.0])
    rho = np.arctan2(n[0], n[1]) % np.pi
    column, row = (int(v * ANGLES / np.pi) for v in (omega, rho))
    around = own.second[max(row - 3, 0) : row + 4, max(column - 2, 0) : column + 3]
    # A map of that many cells, filled evenly, would have a thousandth of them there.
    assert around.max() > 0.3 * own.first.sum()
    assert own.second.sum(axis=0).max() == own.first.sum()
