import numpy as np
import pytest

from endocal.calibration.fit.grouping import LineSpec, group
from endocal.calibration.image.edges import EdgePoints

from ..scenes import TRUTH, line_points

SPEC = LineSpec(distance=1.5, angle=np.deg2rad(6), points=40, span=40)


def test_each_line_is_found_and_clutter_is_left() -> None:
    points, labels, normals = line_points(TRUTH, count=12)
    rng = np.random.default_rng(2)
    turn = rng.uniform(0, 2 * np.pi, 600)
    clutter = rng.uniform((90, 10), (550, 470), (600, 2))
    edges = EdgePoints(
        np.vstack([points, clutter]),
        np.vstack([normals, np.stack([np.cos(turn), np.sin(turn)], axis=1)]),
    )
    found = group(edges, TRUTH, SPEC)
    assert found.count == 12
    own = found.labels[: len(points)]
    assert np.mean(own >= 0) > 0.97
    for label in range(12):
        kinds, counts = np.unique(own[labels == label], return_counts=True)
        assert counts.max() > 0.9 * counts.sum(), (label, kinds, counts)
    assert np.mean(found.labels[len(points) :] >= 0) < 0.1


def test_few_long_lines_have_less_entropy_than_many_short_ones() -> None:
    points, _, normals = line_points(TRUTH, count=12)
    edges = EdgePoints(points, normals)
    right, wrong = (group(edges, TRUTH * [f, 1, 1], SPEC).entropy() for f in (1.0, 0.3))
    # All points on twelve equal lines: ln 12.
    assert right == pytest.approx(np.log(12), abs=0.05)
    assert wrong > right + 0.2
