"""Bent edges, which blur draws toward the middle of their bend."""

from __future__ import annotations

import numpy as np
import pytest

from endocal.calibration.measure.bent import out_of_the_bend
from endocal.calibration.measure.matched import measure_matched
from endocal.calibration.measure.profiles import Measured, measure, smoothed
from endocal.model import DivisionModel
from endocal.synth.sampling import pixel_averages

SIZE, MIDDLE = 240, 119.5
LENS = np.array([-2.0 / SIZE**2, MIDDLE, MIDDLE])
# A line this far from the centre, px in the corrected picture.
AWAY = 90.0
SMOOTHED = 2.0


def picture_and_line(bright: int) -> tuple[np.ndarray, np.ndarray]:
    """A sharp edge that the lens bends, and points (n, 2) on it; ``bright``: which of its sides is."""
    model = DivisionModel(LENS[0], (MIDDLE, MIDDLE), (SIZE, SIZE))

    def side(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        corrected = model.undistort(np.stack(np.broadcast_arrays(x, y), axis=-1))
        return (corrected[..., 1] - MIDDLE > AWAY).astype(np.int32)

    levels = np.array([200.0, 40.0] if bright else [40.0, 200.0], np.float32)
    picture = np.asarray(pixel_averages(side, levels, (0, 0), (SIZE, SIZE)), np.float32)
    t = np.linspace(-100, 100, 200)
    line = model.distort(np.stack([MIDDLE + t, np.full_like(t, MIDDLE + AWAY)], axis=1))
    return picture, line


def measured(bright: int) -> Measured:
    """That edge as measured in the smoothed picture."""
    picture, line = picture_and_line(bright)
    return measure(smoothed(picture, SMOOTHED), line, np.zeros(len(line), np.intp), LENS, True)


def off(points: np.ndarray) -> float:
    """How far, px, points lie off the edge in the mean, away from the centre."""
    here = DivisionModel(LENS[0], (MIDDLE, MIDDLE), (SIZE, SIZE)).undistort(points)
    on = np.stack([here[:, 0], np.full(len(here), MIDDLE + AWAY)], axis=1)
    there = DivisionModel(LENS[0], (MIDDLE, MIDDLE), (SIZE, SIZE)).distort(on)
    return float((points - there)[:, 1].mean())


@pytest.mark.parametrize("bright", [0, 1])
def test_what_blur_draws_off_a_bent_edge_is_put_back(bright: int) -> None:
    lines = measured(bright)
    # A pixel's own area blurs, too.
    mended = out_of_the_bend(lines, np.array([SMOOTHED**2 + 1 / 12]), LENS)
    # The lens bends it round its middle, whichever of its sides is bright.
    assert off(lines.points) < -0.005
    assert abs(off(mended.points)) < 0.09 * abs(off(lines.points))


def test_matched_smoothing_leaves_a_bent_edge_in_its_place() -> None:
    """It blurs as the camera did before, and both are put back."""
    picture, line = picture_and_line(0)
    soft = smoothed(picture, 1.5)
    known = measure(smoothed(soft), line, np.zeros(len(line), np.intp), LENS, True)
    matched = measure_matched(soft, smoothed(soft), known, LENS)
    assert off(known.points) < -0.005
    assert abs(off(matched.points)) < 0.1 * abs(off(known.points))


def test_straight_edges_stay() -> None:
    lines = measured(0)
    flat = np.array([-1e-12, MIDDLE, MIDDLE])
    mended = out_of_the_bend(lines, np.array([4.0]), flat)
    np.testing.assert_allclose(mended.points, lines.points, atol=1e-4)
