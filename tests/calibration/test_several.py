"""Pictures of no pattern, alone or beside others that show one."""

import cv2
import numpy as np
import pytest

from endocal import calibrate
from endocal.calibration.calibrate import calibrate_jointly
from endocal.errors import CalibrationError
from endocal.synth.board import render_board

from .scenes import board


def clouds(seed: int, spread: float) -> np.ndarray:
    """Edges that run as they like."""
    noise = np.random.default_rng(seed).normal(0, 1, (480, 640))
    smooth = cv2.GaussianBlur(noise, (0, 0), spread)
    return np.asarray(255 * (smooth - smooth.min()) / np.ptp(smooth), np.uint8)


def rings() -> np.ndarray:
    y, x = np.mgrid[-240:240, -320:320]
    return np.where(np.hypot(x, y) // 20 % 2 == 0, 200, 40).astype(np.uint8)


def test_pictures_of_no_pattern_are_left_out_however_many_they_are() -> None:
    seen = render_board(board())
    joint = calibrate_jointly([clouds(1, 12), clouds(2, 20), seen, rings()])
    assert joint.silent == (0, 1, 3)
    assert joint.left_out == ()
    assert joint.calibration == calibrate(seen)
    assert joint.calibration.quality.verdict == "good"


@pytest.mark.parametrize("soft", [False, True])
def test_bars_are_a_pattern_beside_a_board(soft: bool) -> None:
    camera = {"noise": 8.0, "blur": 2.5} if soft else {}
    bars = board(kind="lines", tilt=30, axis=20, seed=3, **camera)
    joint = calibrate_jointly([render_board(board()), render_board(bars)])
    assert joint.silent == joint.left_out == ()
    assert joint.calibration.quality.verdict == "good"


def test_where_no_picture_shows_a_pattern_all_are_refused() -> None:
    try:
        joint = calibrate_jointly([clouds(1, 12), clouds(2, 20)])
    except CalibrationError:
        return
    assert joint.silent == ()
    assert joint.calibration.quality.verdict == "failed"
