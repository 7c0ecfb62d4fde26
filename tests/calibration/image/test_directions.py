"""The direction of an edge from the points along it."""

from __future__ import annotations

import numpy as np

from endocal.calibration.image.directions import directions_along
from endocal.calibration.image.edges import EdgePoints


def arc(
    radius: float, noise: float = 0.0, turn: float = 0.0
) -> tuple[EdgePoints, np.ndarray, np.ndarray]:
    """Points a px apart on a circle, off by ``noise`` px, normals turned by ``turn`` degrees; the truth."""
    rng = np.random.default_rng(0)
    angle = np.arange(-100, 101) / radius
    normals = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    points = (50, 40) + radius * normals
    given = np.arctan2(normals[:, 1], normals[:, 0]) + np.deg2rad(rng.normal(0, turn, len(angle)))
    seen = points + rng.normal(0, noise, (len(angle), 1)) * normals
    return EdgePoints(seen, np.stack([np.cos(given), np.sin(given)], axis=1)), points, normals


def off(found: EdgePoints, normals: np.ndarray) -> np.ndarray:
    """By how many degrees normals are off."""
    turned = found.gradients[:, 0] * normals[:, 1] - found.gradients[:, 1] * normals[:, 0]
    return np.rad2deg(np.arcsin(turned))


def test_the_points_along_an_edge_tell_its_direction() -> None:
    edges, _, normals = arc(400.0, noise=0.2, turn=2.0)
    inner = np.arange(20, 181)
    found, told = directions_along(edges, inner, 15.0)
    assert told.all()
    # A line through 31 points that are 1 px apart and off by 0.2 px: 0.2 / sqrt(31 * 80) = 0.23 degrees.
    assert np.std(off(found, normals[inner])) < 0.3


def test_a_bend_turns_no_direction_and_moves_no_point_far() -> None:
    edges, points, normals = arc(300.0)
    inner = np.arange(20, 181)
    found, _ = directions_along(edges, inner, 15.0)
    assert np.abs(off(found, normals[inner])).max() < 1e-3
    # The mean of the sagitta over 15 px to both sides, 15^2 / 6 R, at most.
    assert np.abs(found.points - points[inner]).max() < 15**2 / 6 / 300 + 0.01


def test_at_the_end_of_an_edge_no_direction_is_told() -> None:
    edges, _, _ = arc(400.0)
    found, told = directions_along(edges, np.array([0, 3, 100, 199]), 15.0)
    assert list(told) == [False, False, True, False]
    np.testing.assert_allclose(found.points[0], edges.points[0], atol=1e-12)
    np.testing.assert_allclose(found.gradients[0], edges.gradients[0], atol=1e-12)


def test_other_edges_nearby_do_not_count() -> None:
    y = np.arange(0.0, 101.0)
    # Two edges 4 px apart, one bright to the left and one to the right, which runs askew.
    points = np.concatenate([np.stack([0 * y, y], 1), np.stack([4 - 0.03 * y, y], 1)])
    normals = np.concatenate([np.tile([1.0, 0.0], (101, 1)), np.tile([-1.0, 0.0], (101, 1))])
    found, told = directions_along(EdgePoints(points, normals), np.array([30, 50, 70]), 15.0)
    assert told.all()
    assert np.abs(found.gradients - (1, 0)).max() < 1e-9
    assert np.abs(found.points[:, 0]).max() < 1e-9


def test_few_points_tell_nothing() -> None:
    edges = EdgePoints(np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]), np.tile([0.0, 1.0], (3, 1)))
    _, told = directions_along(edges, np.arange(3), 15.0)
    assert not told.any()
