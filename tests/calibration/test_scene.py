"""What is believed of a scene before a model is sought."""

from __future__ import annotations

import pytest

from endocal.boundary.circle import Boundary
from endocal.calibration.calibrate import calibrate
from endocal.calibration.scene import _widest, look_at
from endocal.calibration.spec import CalibrationSpec
from endocal.synth.board import render_board

from .scenes import board

ASPECTS = (0.5, 1.0, 16 / 15, 2.0)


@pytest.mark.parametrize("aspect", ASPECTS)
def test_the_frames_centre_is_its_middle_pixel_whatever_their_shape(aspect: float) -> None:
    picture = render_board(board())
    spec = CalibrationSpec(center="image", refine=False, pixel_aspect=aspect)
    assert calibrate(picture, spec).model.center == pytest.approx((319.5, 239.5), abs=1e-9)


@pytest.mark.parametrize("aspect", ASPECTS)
def test_the_centre_is_believed_about_the_middle(aspect: float) -> None:
    prior = look_at([render_board(board())], CalibrationSpec(pixel_aspect=aspect)).prior
    assert prior.center == pytest.approx((319.5 * aspect, 239.5))
    assert prior.spread == pytest.approx((32.0 * aspect, 24.0))


def test_the_circle_is_that_of_the_picture_that_shows_most_of_it() -> None:
    least, most, less = (Boundary((320.0, 240.0), 440.0, 1.5e5, v) for v in (0.3, 0.9, 0.6))
    assert _widest([least, None, most, less]) is most
    assert _widest([None, None]) is None
