"""The division model against finite differences, round trips, and its own formula."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from endocal.errors import InputError
from endocal.model import DivisionModel

SIZE = (720, 540)
CORNER = math.hypot(*SIZE) / 2


@st.composite
def models(draw: st.DrawFn, two: bool = True) -> DivisionModel:
    """Models of either sign, λ = 0 among them, that stay valid over the whole frame."""
    reach = 1.4 * CORNER
    strength = draw(st.one_of(st.just(0.0), st.floats(-0.9, 0.9)))
    second = draw(st.one_of(st.just(0.0), st.floats(-0.3, 0.3))) if two else 0.0
    model = DivisionModel(
        lam=strength / reach**2,
        center=(draw(st.floats(300, 420)), draw(st.floats(220, 320))),
        size=SIZE,
        pixel_aspect=draw(st.sampled_from([1.0, 64 / 45, 8 / 9])),
        lam2=second / reach**4,
    )
    assume(model.valid_radius > 1.05 * reach)
    return model


points = st.tuples(st.floats(100, 619), st.floats(60, 479)).map(np.array)


def radius(model: DivisionModel, point: np.ndarray) -> float:
    d = (point - model.center) * [model.pixel_aspect, 1]
    return float(np.hypot(*d))


@given(models(), points)
def test_undistort_is_equation_4(model: DivisionModel, point: np.ndarray) -> None:
    r = radius(model, point)
    expected = model.center + (point - model.center) / (1 + model.lam * r**2 + model.lam2 * r**4)
    assert_allclose(model.undistort(point), expected, atol=1e-9)


@given(models(two=False), points)
def test_distort_is_the_closed_form_inverse(model: DivisionModel, point: np.ndarray) -> None:
    r = radius(model, point)
    # A point that some distorted point maps to: within the valid radius 1 - 4 lam r_u^2 is positive.
    assume(4 * model.lam * r**2 < 0.99)
    expected = model.center + (point - model.center) * 2 / (1 + math.sqrt(1 - 4 * model.lam * r**2))
    assert_allclose(model.distort(point), expected, atol=1e-9)


@given(models(), points)
def test_round_trip(model: DivisionModel, point: np.ndarray) -> None:
    # Both directions lose at most the 1e-12 of the inverse's stopping rule, magnified by its slope.
    assert_allclose(model.distort(model.undistort(point)), point, atol=1e-7)


@given(models(), points)
def test_jacobian_is_the_derivative(model: DivisionModel, point: np.ndarray) -> None:
    h = 1e-3
    steps = np.array([[h, 0], [0, h]])
    numeric = (model.undistort(point + steps) - model.undistort(point - steps)).T / (2 * h)
    # Central differences err by h^2 times the third derivative, here below 1e-3 / px^2.
    assert_allclose(model.jacobian(point), numeric, rtol=1e-5, atol=1e-7)


@given(models(), points, st.floats(0, 2 * math.pi))
def test_undistorted_gradient_is_normal_to_the_undistorted_edge(
    model: DivisionModel, point: np.ndarray, angle: float
) -> None:
    gradient = np.array([math.cos(angle), math.sin(angle)])
    tangent = np.array([-gradient[1], gradient[0]])
    h = 1e-3
    edge = model.undistort(point + h * tangent) - model.undistort(point - h * tangent)
    found = model.undistorted_gradient(point, 7.5 * gradient)
    assert_allclose(np.linalg.norm(found), 1, atol=1e-12)
    assert abs(found @ edge) / np.linalg.norm(edge) < 1e-5
    # On the same side of the edge as before: bright stays bright.
    ahead = model.undistort(point + h * gradient) - model.undistort(point - h * gradient)
    assert found @ ahead > 0


@given(models(two=False), points, st.floats(0, 2 * math.pi))
def test_undistorted_gradient_is_equation_7(
    model: DivisionModel, point: np.ndarray, angle: float
) -> None:
    assume(model.pixel_aspect == 1)
    gx, gy = math.cos(angle), math.sin(angle)
    x, y = point - model.center
    a = -2 * (y * gx - x * gy)
    beta = 1 + model.lam * (x**2 + y**2)
    printed = np.array([-(model.lam * a * y + gx * beta), model.lam * a * x - gy * beta])
    printed /= np.linalg.norm(printed)
    found = model.undistorted_gradient(point, (gx, gy))
    # The article's sign is the opposite one; a line has both.
    assert_allclose(found, -printed, atol=1e-9)


def test_a_line_becomes_a_circle_through_the_relation_of_wang() -> None:
    model = DivisionModel(-1.5e-6, (362.0, 268.0), SIZE)
    t = np.linspace(-300, 300, 25)[:, None]
    line = np.array([350.0, 180.0]) + t * [0.96, 0.28]
    x, y = model.distort(line).T
    design = np.column_stack([x, y, np.ones_like(x)])
    a, b, c = np.linalg.lstsq(design, -(x**2 + y**2), rcond=None)[0]
    assert np.abs(design @ [a, b, c] + x**2 + y**2).max() < 1e-6
    cx, cy = model.center
    # x^2 + y^2 + A x + B y + C = 0 and cx^2 + cy^2 + A cx + B cy + C = 1 / lambda.
    assert_allclose(cx**2 + cy**2 + a * cx + b * cy + c, 1 / model.lam, rtol=1e-6)


@given(models(), points)
def test_the_centre_stays_and_nothing_is_magnified_there(
    model: DivisionModel, point: np.ndarray
) -> None:
    assert_allclose(model.undistort(model.center), model.center)
    assert_allclose(model.distort(model.center), model.center)
    assert_allclose(model.jacobian(model.center), np.eye(2), atol=1e-12)


def test_without_distortion_nothing_moves() -> None:
    model = DivisionModel(0.0, (300.0, 200.0), SIZE)
    grid = np.stack(np.meshgrid(np.arange(0, 720, 90), np.arange(0, 540, 90)), axis=-1)
    assert np.array_equal(model.undistort(grid), grid)
    assert np.array_equal(model.distort(grid), grid)
    assert model.valid_radius == math.inf


@pytest.mark.parametrize(
    ("strength", "second"),
    [(-1.4, 0.0), (0.7, 0.0), (-1.0, 0.2), (0.5, -0.9), (-0.4, -0.8), (-3.0, 1.5), (2.0, 1.0)],
)
def test_valid_radius_is_where_the_map_stops_being_monotonic(
    strength: float, second: float
) -> None:
    model = DivisionModel(strength / CORNER**2, (0.0, 0.0), SIZE, lam2=second / CORNER**4)
    limit = model.valid_radius
    assert math.isfinite(limit)
    r = np.linspace(0, limit * (1 - 1e-6), 20001)
    r_u = r / (1 + model.lam * r**2 + model.lam2 * r**4)
    assert (np.diff(r_u) > 0).all()
    assert (r_u >= 0).all()
    # Right after it, the map turns back or has crossed a pole.
    a, b = limit * (1 + 1e-6), limit * (1 + 2e-6)
    after = [v / (1 + model.lam * v**2 + model.lam2 * v**4) for v in (a, b)]
    assert after[1] < after[0] or after[0] < 0


def test_points_beyond_the_valid_radius_are_nan() -> None:
    model = DivisionModel(-1 / 200**2, (300.0, 200.0), SIZE)
    inside, outside = model.undistort([[300 + 199.9, 200], [300 + 200.1, 200]])
    assert np.isfinite(inside).all()
    assert np.isnan(outside).all()


@pytest.mark.parametrize("second", [0.0, 1e-12])
def test_undistorted_points_that_nothing_maps_to_are_nan(second: float) -> None:
    # Pincushion: r_u has a greatest value, 1 / (2 sqrt(lam)) for one parameter.
    model = DivisionModel(4e-6, (0.0, 0.0), SIZE, lam2=second)
    reach = float(model.undistort([model.valid_radius * (1 - 1e-9), 0])[0])
    assert np.isfinite(model.distort([reach * 0.999, 0])).all()
    assert np.isnan(model.distort([reach * 1.001, 0])).all()


@given(models(), st.floats(0.2, 5), points)
def test_rescale_commutes_with_the_map(
    model: DivisionModel, scale: float, point: np.ndarray
) -> None:
    size = (round(720 * scale), round(540 * scale))
    s = size[1] / 540
    assume(abs(size[0] / 720 - s) < 1e-12)
    scaled = model.rescale(size)
    assert scaled.size == size

    def resized(p: np.ndarray) -> np.ndarray:
        return (p + 0.5) * s - 0.5

    assert_allclose(scaled.undistort(resized(point)), resized(model.undistort(point)), atol=1e-6)


@given(models())
def test_rescale_there_and_back(model: DivisionModel) -> None:
    back = model.rescale((1440, 1080)).rescale(SIZE)
    # Twelve digits, but for numbers so small that a float has fewer.
    assert_allclose(back.lam, model.lam, rtol=1e-12, atol=1e-300)
    assert_allclose(back.lam2, model.lam2, rtol=1e-12, atol=1e-300)
    assert_allclose(back.center, model.center, rtol=1e-12)
    assert model.rescale(SIZE) is model


def test_rescale_refuses_another_shape() -> None:
    with pytest.raises(InputError, match="768x576 does not fit a frame of 1920x1080"):
        DivisionModel(0.0, (383.5, 287.5), (768, 576)).rescale((1920, 1080))


def test_a_pixel_aspect_makes_a_circle_of_the_ellipse() -> None:
    # The same lens in square pixels, and stored with pixels twice as wide.
    square = DivisionModel(-1e-6, (400.0, 300.0), (800, 600))
    wide = DivisionModel(-1e-6, (200.0, 300.0), (400, 600), pixel_aspect=2.0)
    x, y = 123.0, -87.0
    a = square.undistort([400 + x, 300 + y]) - square.center
    b = wide.undistort([200 + x / 2, 300 + y]) - wide.center
    assert_allclose(b * [2, 1], a)


def test_shapes_are_kept() -> None:
    model = DivisionModel(-1e-6, (360.0, 270.0), SIZE)
    grid = np.full((4, 5, 2), 100.0)
    assert model.undistort(grid).shape == grid.shape
    assert model.distort(grid).shape == grid.shape
    assert model.jacobian(grid).shape == (4, 5, 2, 2)
    assert model.undistorted_gradient(grid, np.ones_like(grid)).shape == grid.shape


def cross_ratio(angles: np.ndarray) -> float:
    """The cross ratio of four lines through one point, from their directions."""
    a, b, c, d = angles
    return math.sin(a - c) * math.sin(b - d) / (math.sin(a - d) * math.sin(b - c))


def test_parallel_lines_are_straight_about_other_centres_too() -> None:
    """Lines through one vanishing point leave the centre open along the way to it: docs/accuracy.md."""
    lam, center, vanishing, t = -1.5e-6, np.array([360.0, 270.0]), np.array([900.0, 400.0]), 0.03
    other = DivisionModel(
        lam / (1 - t + lam * t**2 * vanishing @ vanishing), center + t * vanishing, SIZE
    )
    along = np.linspace(-1400, -400, 50)[:, None]
    angles = np.linspace(0.2, 0.7, 6)
    offsets, normals = [], []
    for angle in angles:
        line = center + vanishing + along * (math.cos(angle), math.sin(angle))
        moved = other.undistort(DivisionModel(lam, tuple(center), SIZE).distort(line))
        middle = moved.mean(axis=0)
        _, sizes, ways = np.linalg.svd(moved - middle)
        assert sizes[1] < 1e-9
        normals.append(ways[1])
        offsets.append(ways[1] @ middle)
    point, *_ = np.linalg.lstsq(np.array(normals), np.array(offsets))
    assert_allclose(np.array(normals) @ point, offsets, atol=1e-8)
    turned = np.array([math.atan2(y, x) for x, y in normals])
    assert_allclose(cross_ratio(turned[:4]), cross_ratio(angles[:4]), rtol=1e-9)
    assert_allclose(cross_ratio(turned[2:]), cross_ratio(angles[2:]), rtol=1e-9)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"lam": math.nan}, "lam is nan, not a finite"),
        ({"lam2": math.inf}, "lam2 is inf, not a finite"),
        ({"center": (math.nan, 1.0)}, "center is .*, not two finite"),
        ({"center": "x"}, "center is 'x', not two finite"),
        ({"center": 5.0}, "center is 5.0, not two finite"),
        ({"size": (720, 540, 3)}, "size is .*, not two finite"),
        ({"center": (-721.0, 1.0)}, "far outside"),
        ({"center": (1.0, 1081.0)}, "far outside"),
        ({"size": (0, 540)}, "whole pixels"),
        ({"size": (720.5, 540)}, "whole pixels"),
        ({"pixel_aspect": 0.0}, "not positive"),
    ],
)
def test_a_senseless_model_is_refused(change: dict, message: str) -> None:
    values = {"lam": -1e-6, "center": (360.0, 270.0), "size": SIZE, **change}
    with pytest.raises(InputError, match=message):
        DivisionModel(**values)


def test_numpy_scalars_become_plain_numbers() -> None:
    model = DivisionModel(np.float64(-1e-6), (np.float32(1), np.int64(2)), (np.int64(720), 540))
    assert [type(v) for v in (model.lam, *model.center, *model.size)] == [float] * 3 + [int] * 2
