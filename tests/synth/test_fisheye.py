"""Lenses of other laws than the division model's, and the random boards seen through them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from endocal.errors import UsageError
from endocal.model import DivisionModel
from endocal.synth.board import render_board, true_corners
from endocal.synth.fisheye import PROJECTIONS, Fisheye
from endocal.synth.fisheye_boards import fisheye_board

CENTER, SIZE = (372.5, 236.25), (748, 480)
LENSES = [(name, ()) for name in PROJECTIONS] + [("equidistant", (-0.05, 0.01))]


@pytest.mark.parametrize(("projection", "k"), LENSES)
def test_points_go_out_and_come_back(projection: str, k: tuple[float, ...]) -> None:
    lens = Fisheye(projection, 200.0, CENTER, SIZE, pixel_aspect=1.2, k=k)
    around = np.linspace(0, 2 * np.pi, 50)
    radius = np.linspace(0, 0.97, 50) * lens.valid_radius
    steps = np.stack([np.cos(around) / 1.2, np.sin(around)], axis=1)
    points = CENTER + radius[:, None] * steps
    back = lens.distort(lens.undistort(points))
    # The law's inverse is tabulated, to 1e-8 of the radius.
    np.testing.assert_allclose(back, points, atol=1e-5)
    assert np.isnan(lens.undistort(CENTER + 1.001 * lens.valid_radius * steps)).all()


def test_each_law_is_the_one_it_is_named_for() -> None:
    """At 60 degrees off the axis; a plane before the lens has the tangent of it."""
    seen = {
        name: Fisheye(name, 100.0, (0.0, 0.0), SIZE).distort([100 * math.sqrt(3), 0.0])[0]
        for name in PROJECTIONS
    }
    assert seen == pytest.approx(
        {
            "equidistant": 100 * math.pi / 3,
            "equisolid": 100.0,
            "stereographic": 200 / math.sqrt(3),
            "orthographic": 50 * math.sqrt(3),
        }
    )
    series = Fisheye("equidistant", 100.0, (0.0, 0.0), SIZE, k=(0.1, -0.02))
    t = math.pi / 3
    expected = 100 * (t + 0.1 * t**3 - 0.02 * t**5)
    assert series.distort([100 * math.sqrt(3), 0.0])[0] == pytest.approx(expected)


def test_a_stereographic_lens_is_a_division_model() -> None:
    """2 f tan(t / 2) and f tan(t) are r and r / (1 - r^2 / 4 f^2)."""
    lens = Fisheye("stereographic", 200.0, CENTER, SIZE)
    model = DivisionModel(-1 / (4 * 200.0**2), CENTER, SIZE)
    points = np.random.default_rng(1).uniform((120, 20), (620, 450), (200, 2))
    np.testing.assert_allclose(lens.undistort(points), model.undistort(points), atol=1e-4)


def test_an_unknown_law_is_refused() -> None:
    with pytest.raises(UsageError, match="projection 'flat' is none of equidistant"):
        Fisheye("flat", 200.0, CENTER, SIZE)


def test_no_division_model_is_a_fisheyes_truth() -> None:
    scenes = [fisheye_board(seed) for seed in range(12)]
    kinds = {type(scene.model) for scene in scenes}
    assert kinds == {DivisionModel, Fisheye}
    for scene in scenes:
        if isinstance(scene.model, Fisheye):
            with pytest.raises(UsageError, match="no division model"):
                _ = scene.division
        else:
            assert scene.division is scene.model


def test_random_boards_are_wholly_in_view_and_reach_the_rim() -> None:
    reach = []
    for seed in range(30):
        scene = fisheye_board(seed)
        corners, seen = true_corners(scene)
        assert seen.all()
        away = np.linalg.norm(corners - np.array(scene.circle.center), axis=-1)
        reach.append(away.max() / (scene.circle.diameter / 2))
    assert max(reach) > 0.85
    # Some boards lie about the middle.
    assert min(reach) < 0.5


def test_a_seed_tells_a_picture() -> None:
    assert fisheye_board(5) == fisheye_board(5) != fisheye_board(6)
    picture = render_board(fisheye_board(5))
    assert picture.shape == fisheye_board(5).model.size[::-1]
