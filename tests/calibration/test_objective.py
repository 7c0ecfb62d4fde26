import numpy as np
import pytest

from endocal.calibration.objective import region_of
from endocal.calibration.scene import look_at
from endocal.calibration.spec import CalibrationSpec
from endocal.synth.board import render_board

from .scenes import board


@pytest.mark.parametrize("times", [1, 8])
def test_a_large_picture_leaves_lambda_a_range_that_holds_it(times: int) -> None:
    scene = board()
    picture = np.kron(render_board(scene), np.ones((times, times), np.uint8))
    strongest, weakest = region_of(look_at([picture], CalibrationSpec())).lam
    assert strongest < scene.model.lam / times**2 < weakest < 0
