import numpy as np
import pytest

from endocal.calibration.straightness import PointsOnLines, Undistorted, residuals
from endocal.model import DivisionModel

from .scenes import TRUTH, line_points


@pytest.mark.parametrize(
    "params", [TRUTH, np.array([*TRUTH[:3] * [0.5, 1, 1], -8e-13]), TRUTH * [0, 1, 1]]
)
def test_true_lines_are_straight_under_the_truth(params: np.ndarray) -> None:
    points, labels, _ = line_points(params)
    # 4e-4 px: what eleven digits of radius leave after the inverse of the two-parameter model.
    assert np.abs(residuals(points, labels, params)).max() < 4e-4
    assert (
        np.abs(residuals(points, labels, params * [1.2, 1, 1, 1][: len(params)])).max() > 0.1
        or params[0] == 0
    )


def test_distances_are_those_in_the_distorted_picture() -> None:
    points, labels, normals = line_points(TRUTH, each=200)
    rng = np.random.default_rng(0)
    moved = rng.normal(0, 0.05, len(points))
    r = residuals(points + moved[:, None] * normals, labels, TRUTH)
    # The lines' fits take up two of each line's 200 degrees of freedom.
    agreement = np.corrcoef(np.abs(r), np.abs(moved))[0, 1]
    assert agreement > 0.97
    assert r.std() == pytest.approx(moved.std(), rel=0.02)


def test_grown_bright_sides_are_taken_off() -> None:
    points, labels, normals = line_points(TRUTH, each=200)
    sides = np.where(np.arange(len(points)) // 20 % 2 == 0, 1.0, -1.0)
    grown = points + 0.4 * sides[:, None] * normals
    assert residuals(grown, labels, TRUTH).std() > 0.3
    assert residuals(grown, labels, TRUTH, sides=sides).std() < 0.02


def test_gradients_and_scale_agree_with_the_model() -> None:
    points, _, normals = line_points(TRUTH)
    model = DivisionModel(TRUTH[0], tuple(TRUTH[1:]), (2000, 2000))
    at = Undistorted.of(points, TRUTH)
    np.testing.assert_allclose(at.u + TRUTH[1:], model.undistort(points), atol=1e-9)
    expected = model.undistorted_gradient(points, normals)
    turned = at.gradients(normals)
    np.testing.assert_allclose(np.abs((turned * expected).sum(axis=1)), 1, atol=1e-12)
    jacobian = model.jacobian(points)
    np.testing.assert_allclose(
        at.pulled_back(expected), np.einsum("nij,ni->nj", jacobian, expected), atol=1e-12
    )


def test_the_order_of_points_does_not_matter() -> None:
    """Lines in order are summed in another way than lines that are not; a label may have no point."""
    points, labels, _ = line_points(TRUTH, count=6, each=40)
    labels = np.where(labels == 2, 7, labels)
    shuffled = np.random.default_rng(5).permutation(len(points))
    off = TRUTH + np.array([2e-7, 3.0, -2.0])
    ordered = np.argsort(labels, kind="stable")
    one = residuals(points[ordered], labels[ordered], off)
    other = residuals(points[shuffled], labels[shuffled], off)
    np.testing.assert_allclose(one[np.argsort(ordered)], other[np.argsort(shuffled)], atol=1e-9)
    assert np.abs(one).max() > 0.1


def test_the_derivatives_by_growth_are_those_of_the_residuals() -> None:
    rng = np.random.default_rng(3)
    points, labels, _ = line_points(TRUTH, count=6, each=40)
    points = points + rng.normal(0, 0.1, points.shape)
    columns = rng.normal(0, 1, (len(points), 2))
    seen = PointsOnLines(points, labels, sides=rng.choice([-1.0, 1.0], len(points))).under(TRUTH)
    slopes = seen.by_growth(columns)
    for column, slope in zip(columns.T, slopes.T, strict=True):
        expected = seen.residuals(column) - seen.residuals(np.zeros(len(points)))
        np.testing.assert_allclose(slope, expected, atol=1e-12)
        assert np.abs(slope).max() > 0.5
