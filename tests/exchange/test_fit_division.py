"""A division model that went through OpenCV's comes back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import cv2
import numpy as np
import pytest

from endocal.errors import InputError
from endocal.exchange.camera import Camera
from endocal.exchange.fit_camera import fit_camera
from endocal.exchange.fit_division import fit_division
from endocal.model import DivisionModel
from tests.exchange import lenses

Lens = Callable[[], tuple[DivisionModel, float]]
ENDOSCOPE_CIRCLE = (360.0, 268.0, 527.0)


def at_rim(lam: float, radius: float) -> float:
    """How far lambda moves the farthest content, px of the distorted picture, to first order."""
    return lam * radius**3


@pytest.mark.parametrize(
    "lens", [lenses.endoscope, lenses.narrow, lenses.anamorphic, lenses.pincushion]
)
def test_the_rational_model_brings_the_lens_back(lens: Lens) -> None:
    model, radius = lens()
    out = fit_camera(model, radius, rational=True)
    circle = (*model.center, 1.9 * radius)
    back = fit_division(replace(out.camera, circle=circle))
    told = out.largest + back.largest
    # Both least-squares fits end where the cost falls by no more than 1e-8 of itself.
    assert told < 2e-3
    assert abs(at_rim(back.model.lam - model.lam, radius)) <= told + 2e-3
    assert np.abs(np.subtract(back.model.center, model.center)).max() <= told + 2e-2
    assert back.model.pixel_aspect == pytest.approx(model.pixel_aspect, rel=1e-9)
    assert back.model.size == model.size
    assert back.reach is None


@pytest.mark.parametrize(
    ("lens", "circle"), [(lenses.endoscope, ENDOSCOPE_CIRCLE), (lenses.narrow, None)]
)
def test_the_polynomial_brings_it_back_within_its_error(lens: Lens, circle) -> None:
    model, radius = lens()
    out = fit_camera(model, radius)
    back = fit_division(replace(out.camera, circle=circle))
    told = out.largest + back.largest
    # The magnification is free in the comparison and trades against lambda: a little more than the error.
    assert abs(at_rim(back.model.lam - model.lam, radius)) <= 1.5 * told
    assert np.abs(np.subtract(back.model.center, model.center)).max() <= told


def test_two_parameters_come_back() -> None:
    model, radius = lenses.two_parameters()
    out = fit_camera(model, radius, rational=True)
    camera = replace(out.camera, circle=(360.0, 268.0, 500.0))
    one, two = fit_division(camera), fit_division(camera, two_parameters=True)
    assert two.largest < 0.01 < one.largest
    assert two.model.lam == pytest.approx(model.lam, rel=0.01)
    assert two.model.lam2 == pytest.approx(model.lam2, rel=0.01)


def test_tangential_coefficients_move_the_centre() -> None:
    # r^2 p + 2 (p . x) x is what a shift of the centre does to k1 |x|^2 x, to first order, by -p / k1.
    k1, p, f = -0.04, 4e-5, 500.0
    camera = Camera((f, f), (319.5, 239.5), (k1, 0.0, 0.0, p, 0.0), (640, 480))
    fit = fit_division(camera)
    shift = fit.model.center[0] - 319.5, fit.model.center[1] - 239.5
    assert shift[0] == pytest.approx(-p / k1 * f, rel=0.1)
    assert abs(shift[1]) < 0.02
    # A cubic and the division model with the same third-order term differ by 1.5 k1^2 r^5 at most.
    assert fit.largest < 1.5 * k1**2 * 0.8**5 * f


def test_a_fisheye_camera_is_what_opencv_says_it_is() -> None:
    camera = Camera(
        (400.0, 400.0), (320.0, 240.0), (0.02, -0.01, 0.0, 0.0), (640, 480), fisheye=True
    )
    rays = np.array([[0.3, -0.2], [0.0, 0.9], [1.4, 0.1]])
    solid = np.column_stack([rays, np.ones(3)])[:, None]
    theirs, _ = cv2.fisheye.projectPoints(
        solid, np.zeros(3), np.zeros(3), camera.matrix, np.array(camera.coefficients)
    )
    assert camera.distorted(rays) == pytest.approx(theirs[:, 0], abs=1e-9)
    fit = fit_division(camera)
    # An equidistant lens of 53 degrees is nearly stereographic, which is lambda = -1 / (2 f)^2.
    assert fit.model.lam == pytest.approx(-1 / (4 * 400.0**2), rel=0.5)
    assert fit.largest < 2.0


def test_the_fit_ends_where_the_other_model_folds() -> None:
    # r (1 + k1 r^2) is largest at r = 1 / sqrt(-3 k1), where it is 2/3 of that r.
    k1, f = -0.5, 300.0
    camera = Camera((f, f), (319.5, 239.5), (k1, 0.0, 0.0, 0.0, 0.0), (640, 480))
    fit = fit_division(camera)
    assert fit.reach == pytest.approx(f * 2 / 3 / np.sqrt(-3 * k1), rel=0.02)
    assert fit.model.valid_radius > fit.reach


def test_a_centre_outside_the_content_is_refused() -> None:
    camera = Camera((300.0, 300.0), (900.0, 240.0), (0.0,) * 5, (640, 480))
    with pytest.raises(InputError, match="principal point lies outside"):
        fit_division(camera)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"focal": (0.0, 500.0)}, "focal length"),
        ({"coefficients": (0.1, 0.2, 0.3)}, "3 distortion coefficients"),
        ({"coefficients": (0.1,) * 5, "fisheye": True}, "5 distortion coefficients"),
        ({"center": (float("nan"), 0.0)}, "not a finite number"),
        ({"circle": (1.0, 2.0, -3.0)}, "no visible circle"),
        ({"size": (0, 480)}, "no image size"),
    ],
)
def test_what_is_no_camera_is_refused(change, words: str) -> None:
    sound = Camera((500.0, 500.0), (320.0, 240.0), (0.0,) * 5, (640, 480))
    with pytest.raises(InputError, match=words):
        replace(sound, **change)
