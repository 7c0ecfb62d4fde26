"""What is believed of a scene before a model is sought."""

from __future__ import annotations

import pytest

from endocal.calibration.calibrate import calibrate
from endocal.calibration.scene import look_at
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
