"""Lines followed to their ends."""

from __future__ import annotations

import numpy as np

from endocal.calibration.fit.following import FARTHEST, followed
from endocal.calibration.image.edges import EdgePoints


def arc(radius: float, first: float, last: float) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 2) a px apart on a circle about (0, radius), from ``first`` px along on; their normals."""
    turn = np.arange(first, last) / radius
    normals = np.stack([np.sin(turn), -np.cos(turn)], axis=1)
    return (0.0, radius) + radius * normals, normals


def edges_of(*parts: tuple[np.ndarray, np.ndarray]) -> EdgePoints:
    return EdgePoints(*(np.concatenate(v) for v in zip(*parts, strict=True)))


def test_a_bent_line_goes_on_over_a_crossing_to_its_end() -> None:
    # Found from 60 to 160 px along, and seen from 30 to 190; nothing is seen near crossings at 55 and 165.
    seen = [arc(250.0, *ends) for ends in ((30, 50), (60, 160), (170, 190))]
    edges = edges_of(*seen)
    found = np.repeat([-1, 0, -1], [20, 100, 20])
    assert (followed(edges, found, 1) == 0).all()


def test_what_runs_beside_it_or_across_is_left() -> None:
    points, normals = arc(250.0, 0, 150)
    beside = points[110:] - 4.0 * normals[110:], normals[110:]
    across = points[130] + np.linspace(-20, 20, 41)[:, None] * normals[130], np.full((41, 2), 0.0)
    across[1][:] = normals[130][::-1] * (1, -1)
    edges = edges_of((points[:100], normals[:100]), beside, across)
    found = np.repeat([0, -1], [100, 81])
    np.testing.assert_array_equal(followed(edges, found, 1), found)


def test_no_line_is_followed_for_long_nor_takes_anothers_points() -> None:
    line, other = arc(1e5, 0, 400), arc(1e5, 400, 500)
    edges = edges_of(line, other)
    found = np.full(500, -1)
    found[:100] = 0
    assert 100 * (1 + FARTHEST) <= np.count_nonzero(followed(edges, found, 1) == 0) < 170
    found[100:] = 1
    np.testing.assert_array_equal(followed(edges, found, 2), found)


def test_too_short_a_line_tells_no_way_on() -> None:
    edges = edges_of(arc(250.0, 0, 100))
    found = np.repeat([0, -1], [8, 92])
    np.testing.assert_array_equal(followed(edges, found, 1), found)


def test_on_a_large_picture_lengths_are_those_of_the_reduced_one() -> None:
    points, normals = arc(250.0, 0, 150)
    edges = EdgePoints(5 * points, normals)
    found = np.repeat([0, -1], [110, 40])
    assert (followed(edges, found, 1, step=5) == 0).all()
    np.testing.assert_array_equal(followed(edges, found, 1), found)
