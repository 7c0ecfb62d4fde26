"""Places of a reduced picture, and what they are without distortion."""

from __future__ import annotations

import numpy as np
import pytest

from endocal.model import DivisionModel
from endocal.zoom.table import Setting, ZoomTable
from endocal.zoom.view import View, center_drift, guessed_focal, undistorted

DIAMETER = 900.0
# Pixels wider than high, reduced three times, and a lens of two parameters.
MODEL = DivisionModel(-1.3 / DIAMETER**2, (325.0, 236.0), (640, 480), 16 / 15, -0.8 / DIAMETER**4)
VIEW = View(MODEL, DIAMETER, 3)
PLACES = np.random.default_rng(1).uniform(0, (212, 159), (50, 2))


def test_places_are_undistorted_as_the_model_has_it() -> None:
    # The middle of a reduced pixel is that of the three by three it was made of.
    full = 3 * PLACES + 1
    expected = (MODEL.undistort(full) - MODEL.center) * (MODEL.pixel_aspect, 1.0) / DIAMETER
    assert VIEW.undistorted(PLACES) == pytest.approx(expected, abs=1e-12)


def test_places_come_back() -> None:
    assert VIEW.places(VIEW.undistorted(PLACES)) == pytest.approx(PLACES, abs=1e-6)


def test_what_a_lens_of_the_other_sign_does_not_show_is_nowhere() -> None:
    pincushion = View(DivisionModel(1.3 / DIAMETER**2, (325.0, 236.0), (640, 480)), DIAMETER, 3)
    seen = pincushion.places(np.array([[0.1, 0.0], [2.0, 0.0]]))
    assert np.isfinite(seen).all(axis=1).tolist() == [True, False]


def test_the_derivative_is_that_of_the_undistorted_places() -> None:
    n, step = VIEW.offsets(PLACES) / DIAMETER, 1e-6
    _, stretch = undistorted(n, *VIEW.strengths)
    for axis, ahead in enumerate(np.eye(2) * step):
        there, back = (undistorted(n + sign * ahead, *VIEW.strengths)[0] for sign in (1, -1))
        assert stretch[:, :, axis] == pytest.approx((there - back) / (2 * step), abs=1e-7)


def test_a_focal_length_is_guessed_from_the_distortion_and_is_never_endless() -> None:
    assert -1.2 * guessed_focal(-1.0, -0.8, 0.36) ** 2 == pytest.approx(-0.36)
    assert guessed_focal(0.0, 0.0, 0.36) == guessed_focal(-0.05, 0.0, 0.36) < 2.0


def test_the_drift_of_the_centre_counts_in_px_of_the_height() -> None:
    # By 20 px of the frame to the right and 10 down, over a zoom by e.
    places = [(300.0 + 20 * i / 8, 230.0 + 10 * i / 8) for i in range(9)]
    diameters = 400 * np.exp(np.linspace(0, 1, 9))
    table = ZoomTable(
        tuple(Setting(-1.3 / d**2, c, float(d)) for d, c in zip(diameters, places, strict=True)),
        (640, 480),
        16 / 15,
    )
    # Between two settings the centre goes evenly with the diameter, not with its logarithm.
    for diameter in diameters[1:-1]:
        assert center_drift(table, diameter) == pytest.approx((20 * 16 / 15, 10), rel=0.1)
