"""The distribution of random boards is the stated one."""

from __future__ import annotations

import numpy as np
import pytest

from endocal.boundary.circle import Boundary
from endocal.boundary.content import content_radius
from endocal.synth.board import BoardScene, plane_coordinates, render_board, true_corners, visible
from endocal.synth.random import DEEPEST, SIZES, STRONGEST, WEAKEST, random_board

SCENES = [random_board(seed) for seed in range(300)]


def inner_strength(scene: BoardScene) -> float:
    """lam R^2 at the farthest visible content."""
    circle, model = scene.circle, scene.model
    boundary = Boundary(circle.center, circle.diameter, 0.0, 1.0) if circle else None
    return model.lam * content_radius(model.center, model.size, boundary) ** 2


def corner_strength(scene: BoardScene) -> float:
    """lam R^2 at the farthest corner of the frame."""
    return scene.model.lam * content_radius(scene.model.center, scene.model.size) ** 2


def share(values: list[bool]) -> float:
    return sum(values) / len(values)


def test_no_visible_place_is_folded() -> None:
    assert min(inner_strength(s) for s in SCENES) > DEEPEST - 0.01


def test_distortion_covers_its_range() -> None:
    # One pixel more or less in R is up to 2 % of lam R^2 in the smallest frame.
    visible_strengths = [inner_strength(s) for s in SCENES]
    assert 0.97 * WEAKEST > max(visible_strengths) > 2 * WEAKEST
    assert min(visible_strengths) < 0.95 * DEEPEST
    # Without a circle the content ends at the corner; what is drawn beyond DEEPEST has a circle.
    open_frames = [corner_strength(s) for s in SCENES if s.circle is None]
    assert min(open_frames) > DEEPEST - 0.01
    beyond = [corner_strength(s) < DEEPEST for s in SCENES]
    assert 0.35 < share(beyond) < 0.8
    assert min(corner_strength(s) for s in SCENES) < 0.95 * STRONGEST


def test_centers_fill_the_central_region_and_nothing_else() -> None:
    relative = np.array(
        [
            (np.array(s.model.center) - (np.array(s.model.size) - 1) / 2) / s.model.size
            for s in SCENES
        ]
    )
    assert np.abs(relative).max() <= 0.05
    assert (relative.max(axis=0) > 0.045).all()
    assert (relative.min(axis=0) < -0.045).all()


def test_everything_is_drawn_over_its_whole_range() -> None:
    assert {s.model.size for s in SCENES} == set(SIZES)
    for low, high, values in (
        (0, 45, [s.pose.tilt for s in SCENES]),
        (0, 10, [s.camera.noise for s in SCENES]),
        (0, 2, [s.camera.blur for s in SCENES]),
        (70, 100, [float(s.camera.jpeg or 0) for s in SCENES]),
        (8, 20, [float(s.pattern.cols - 1) for s in SCENES]),
        (8, 20, [float(s.pattern.rows - 1) for s in SCENES]),
    ):
        margin = 0.1 * (high - low)
        assert low <= min(values) < low + margin
        assert high - margin < max(values) <= high


@pytest.mark.parametrize(
    ("what", "low", "high"),
    [
        ("lines", 0.12, 0.28),
        ("circle", 0.5, 0.9),
        ("vignetting", 0.4, 0.8),
        ("highlights", 0.25, 0.55),
        ("instruments", 0.15, 0.45),
        ("comb", 0.05, 0.25),
        ("gamma", 0.3, 0.7),
        ("text", 0.15, 0.6),
        ("grey", 0.3, 0.7),
        ("cut", 0.3, 0.7),
    ],
)
def test_each_nuisance_is_there_in_its_share_of_scenes(what: str, low: float, high: float) -> None:
    def has(s: BoardScene) -> bool:
        return {
            "lines": s.pattern.kind == "lines",
            "circle": s.circle is not None,
            "vignetting": s.camera.vignetting > 0,
            "highlights": bool(s.highlights),
            "instruments": bool(s.instruments),
            "comb": s.comb != (0.0, 0.0),
            "gamma": s.camera.gamma > 1,
            "text": bool(s.overlays),
            "grey": s.camera.tint is None,
            "cut": not true_corners(BoardScene(s.model, s.pattern, s.pose, s.circle))[1].all(),
        }[what]

    assert low < share([has(s) for s in SCENES]) < high


def test_the_pattern_covers_a_fair_share_of_the_content() -> None:
    for scene in SCENES[::3]:
        w, h = scene.model.size
        y, x = np.mgrid[0:h:4, 0:w:4]
        points = np.stack([x, y], -1).astype(float)
        plain = BoardScene(scene.model, scene.pattern, scene.pose, scene.circle)
        seen = points[visible(plain, points)]
        half = np.array([scene.pattern.cols, scene.pattern.rows]) / 2
        on_pattern = np.all(np.abs(plane_coordinates(plain, seen)) < half, axis=-1)
        assert on_pattern.mean() > 0.28


def test_a_seed_is_a_picture() -> None:
    for seed in (3, 6):
        scene = random_board(seed)
        assert scene == random_board(seed) != random_board(seed + 1)
        picture = render_board(scene)
        np.testing.assert_array_equal(picture, render_board(scene))
        assert picture.shape[:2] == scene.model.size[::-1]
        assert picture.std() > 10
