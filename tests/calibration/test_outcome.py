"""What is said of a model that folds inside what is seen."""

from __future__ import annotations

import pytest

from endocal.calibration.outcome import _with_usable_radius
from endocal.calibration.result import Calibration
from endocal.model import DivisionModel

# From the middle to a corner of the frame.
CORNER = 400.0


def of_fold(radius: float) -> Calibration:
    """A lens that folds so many px from the middle of a frame of 640 x 480 px."""
    return Calibration(DivisionModel(-(radius**-2), (319.5, 239.5), (640, 480)))


@pytest.mark.parametrize("share", [0.5, 0.9, 0.99])
def test_a_model_is_used_to_just_short_of_a_fold_that_is_seen(share: float) -> None:
    """At the fold itself a pixel is magnified without bound."""
    calibration = of_fold(share * CORNER)
    fold = calibration.model.valid_radius
    assert fold == pytest.approx(share * CORNER)
    used = _with_usable_radius(calibration).usable_radius
    assert used is not None
    assert 0.95 * fold < used < 0.99 * fold


def test_where_no_fold_is_seen_it_holds_for_all() -> None:
    calibration = of_fold(1.01 * CORNER)
    assert _with_usable_radius(calibration) is calibration
