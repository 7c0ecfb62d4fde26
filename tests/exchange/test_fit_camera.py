"""The fitted camera is the division model, as OpenCV itself evaluates it, within the error that is told."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
import pytest

from endocal.errors import InputError
from endocal.exchange.fit_camera import fit_camera
from endocal.model import DivisionModel
from tests.exchange import lenses

Lens = Callable[[], tuple[DivisionModel, float]]


def opencv_gap(camera, model: DivisionModel, radius: float) -> np.ndarray:
    """How far cv2's rectifying map is from the model's, px, where it shows the content."""
    maps = cv2.initUndistortRectifyMap(
        camera.matrix, np.array(camera.coefficients), None, camera.matrix, model.size, cv2.CV_32FC1
    )
    i, j = np.meshgrid(*(np.arange(n) for n in model.size))
    own = model.distort(np.stack([i, j], axis=-1))
    metric = np.array([model.pixel_aspect, 1.0])
    gap = np.hypot(*np.moveaxis((np.stack(maps, axis=-1) - own) * metric, -1, 0))
    return gap[np.hypot(*np.moveaxis((own - model.center) * metric, -1, 0)) <= radius]


@pytest.mark.parametrize("rational", [False, True], ids=["polynomial", "rational"])
@pytest.mark.parametrize("lens", lenses.ALL)
def test_opencv_rectifies_as_the_model_does(lens: Lens, rational: bool) -> None:
    model, radius = lens()
    fit = fit_camera(model, radius, rational)
    assert len(fit.camera.coefficients) == (8 if rational else 5)
    gap = opencv_gap(fit.camera, model, radius)
    # OpenCV's map has 24 bits: 1e-4 px at 2000 px.
    assert gap.max() <= fit.largest + 3e-4
    assert fit.rms <= fit.largest


@pytest.mark.parametrize("lens", lenses.ALL)
def test_the_rational_model_is_the_lens_to_the_eye(lens: Lens) -> None:
    model, radius = lens()
    rational, polynomial = (fit_camera(model, radius, r) for r in (True, False))
    # A tenth of the finest accuracy that calibrating from pictures reaches, 0.01 px.
    assert rational.largest < 1e-3
    assert rational.largest <= polynomial.largest


def test_the_told_error_is_met_in_the_picture() -> None:
    # A bound that is never met would say nothing: the worst radius lies within the picture.
    model, radius = lenses.endoscope()
    fit = fit_camera(model, 0.8 * radius)
    assert opencv_gap(fit.camera, model, 0.8 * radius).max() > 0.9 * fit.largest


def test_the_focal_length_only_scales_the_coefficients() -> None:
    model, radius = lenses.anamorphic()
    free, given = fit_camera(model, radius, True), fit_camera(model, radius, True, focal=900.0)
    assert given.camera.focal == (900.0 / model.pixel_aspect, 900.0)
    rays = np.random.default_rng(1).uniform(-0.5, 0.5, (200, 2))
    ratio = free.camera.focal[1] / 900.0
    a, b = free.camera.distorted(rays), given.camera.distorted(rays * ratio)
    # The coefficients are written with 12 digits.
    assert np.abs(a - b).max() < 1e-6


def test_no_distortion_is_no_coefficients() -> None:
    fit = fit_camera(DivisionModel(0.0, (50.0, 40.0), (100, 80)), 60.0, rational=True)
    assert fit.camera.coefficients == (0.0,) * 8
    assert fit.largest < 1e-9


def test_a_content_beyond_the_fold_is_refused() -> None:
    with pytest.raises(InputError, match="folds within its content"):
        fit_camera(DivisionModel(-1e-4, (50.0, 40.0), (100, 80)), 101.0)
