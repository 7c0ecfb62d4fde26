"""The places of lines, summed up over their points."""

from __future__ import annotations

import numpy as np
import pytest

from endocal.calibration.fit.line_places import LinePlaces
from endocal.calibration.measure.profiles import Measured

from ..scenes import TRUTH, line_points

NO_GROWTH = np.empty(0)


def measured(shift: float = 0.0) -> Measured:
    """Lines seen through the true lens, from both sides; edges ``shift`` px to the left of each."""
    points, labels, normals = line_points(TRUTH)
    way = np.gradient(points, axis=0)
    left = np.where(way[:, 1] * normals[:, 0] - way[:, 0] * normals[:, 1] > 0, -1.0, 1.0)
    points = points + shift * left[:, None] * normals
    sides = np.where(np.arange(len(points)) // 20 % 2, 1.0, -1.0)
    return Measured(points, labels, sides, np.zeros((len(points), 3)), np.ones(len(points)))


def places(
    m: Measured, params: np.ndarray = TRUTH, columns: np.ndarray | None = None
) -> LinePlaces:
    lines = np.arange(int(m.labels.max()) + 1)
    growth = np.empty((len(m.points), 0)) if columns is None else columns
    return LinePlaces.of(m, lines, params, np.ones(len(m.points)), growth)


def test_a_line_is_where_its_points_are() -> None:
    at = places(measured())
    own = np.column_stack([at.normals, -at.offsets])
    np.testing.assert_allclose(at.off(own, NO_GROWTH), 0, atol=1e-6)
    np.testing.assert_allclose(at.off(-own, NO_GROWTH), 0, atol=1e-6)


@pytest.mark.parametrize("move", [(0.0, 2.0), (0.01, 0.0)], ids=["aside", "turned"])
def test_departures_add_up_to_the_distances_they_mean(move: tuple[float, float]) -> None:
    """Without a lens the distance from a line is the same in the picture as it is, but for the sides."""
    m = measured()
    straight = np.array([0.0, *TRUTH[1:]])
    at = places(m, straight)
    angle = np.arctan2(at.normals[:, 1], at.normals[:, 0]) + move[0]
    moved = np.column_stack([np.cos(angle), np.sin(angle), -at.offsets - move[1]])
    own = np.column_stack([at.normals, -at.offsets])
    u = np.column_stack([m.points - straight[1:], np.ones(len(m.points))])
    distance = np.einsum("ni,ni->n", u, (moved - own)[m.labels])
    # Either side of a line has an edge of its own; what both share is its place.
    for line in range(len(own)):
        d, s = distance[m.labels == line], m.sides[m.labels == line]
        left = d - s * (d @ s) / (s @ s)
        total = np.sum(at.off(moved, NO_GROWTH)[line] ** 2)
        assert total == pytest.approx(left @ left, rel=0.02)


def test_growth_is_taken_off() -> None:
    """Edges moved to the left by a third of a pixel are where they were, once that is known."""
    m = measured(shift=1 / 3)
    at = places(m, columns=np.ones((len(m.points), 1)))
    true = places(measured())
    lines = np.column_stack([true.normals, -true.offsets])
    before = np.abs(at.off(lines, np.array([0.0]))).max()
    # A second order of a third of a pixel is left.
    assert np.abs(at.off(lines, np.array([1 / 3]))).max() < 0.05 * before
