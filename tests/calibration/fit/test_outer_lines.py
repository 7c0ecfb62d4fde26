"""Lines in the surround: a sheet's edge is taken, rims are not."""

import numpy as np
import pytest

from endocal.calibration.fit.grouping import LineSpec
from endocal.calibration.fit.outer_lines import with_outer_lines
from endocal.calibration.fit.view import View
from endocal.calibration.image.edges import EdgePoints
from endocal.model import DivisionModel

MODEL = DivisionModel(-2.4e-6, (319.5, 239.5), (640, 480))
SPEC = LineSpec(1.5, np.deg2rad(6), 25, 20.0)
NO_LINES = np.empty((0, 2)), np.empty(0, np.intp)


def taken(points: np.ndarray, lam: float = MODEL.lam) -> int:
    """How many lines are taken of edge points in order, in the noise of edges, under a lens of ``lam``."""
    ways = np.gradient(points, axis=0)
    normals = np.stack([-ways[:, 1], ways[:, 0]], axis=1)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    noisy = points + np.random.default_rng(3).normal(0, 0.2, len(points))[:, None] * normals
    view = View(
        np.zeros((480, 640), np.float32), EdgePoints.none(), outer=EdgePoints(noisy, normals)
    )
    params = np.array([lam, *MODEL.center])
    _, labels = with_outer_lines(view, *NO_LINES, params, SPEC)
    return len(np.unique(labels))


def seen_line(half: float) -> np.ndarray:
    """A straight line 180 px off the middle, as the lens shows it."""
    along = np.arange(-half, half)
    return MODEL.distort(np.stack([320 + along, np.full_like(along, 239.5 - 220)], axis=1))


def test_an_edge_that_is_straight_under_the_model_is_a_line() -> None:
    assert taken(seen_line(150)) == 1


def test_one_too_short_to_be_told_from_a_rim_is_not_taken() -> None:
    assert taken(seen_line(40)) == 0


def test_the_arc_of_a_circle_is_a_rim() -> None:
    for radius in (150.0, 200.0, 230.0):
        turn = np.linspace(0.3, 2.5, int(2 * radius))
        circle = [322.0, 237.0] + radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)
        assert taken(circle) == 0


def arc(radius: float, half: float) -> np.ndarray:
    """So much of a circle to both sides of its highest place, which is 200 px above the distortion centre."""
    turn = np.arange(-half, half) / radius
    x, y = MODEL.center
    return np.array([x, y - 200 + radius]) + radius * np.stack([np.sin(turn), -np.cos(turn)], 1)


@pytest.mark.parametrize("radius", [400.0, 600.0])
def test_an_arc_that_bends_less_than_a_rim_and_more_than_a_line_is_not_taken(radius: float) -> None:
    assert taken(arc(radius, 60)) == 0


@pytest.mark.parametrize("half", [60.0, 100.0])
def test_the_rim_of_a_lens_that_bends_lines_as_much_is_not_taken(half: float) -> None:
    """It lies 10 px off the distortion centre, and is straight under the model."""
    assert taken(arc(210.0, half), lam=-0.9 / 200**2) == 0


def test_the_straight_side_of_a_mask_is_a_rim() -> None:
    along = np.arange(100.0, 540.0)
    assert taken(np.stack([along, np.full_like(along, 60.0)], axis=1)) == 0
