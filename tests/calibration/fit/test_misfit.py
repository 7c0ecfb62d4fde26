"""What bends all of a line is told from noise, and weighs as the corrected picture shows it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

from endocal import CalibrationSpec, DivisionModel, calibrate
from endocal.benchmarks.corner_score import straightness
from endocal.calibration.fit.misfit import misfit, trust_by_magnification
from endocal.synth.board import render_board, true_corners

from ..scenes import TRUTH, board, line_points


@pytest.mark.parametrize(("noise", "bend"), [(0.2, 0.0), (0.2, 0.3), (0.02, 0.15)])
def test_noise_and_bend_are_told_apart(noise: float, bend: float) -> None:
    """Lines bent as half a wave, besides noise that neighbouring profiles share."""
    rng = np.random.default_rng(3)
    lines, each = 40, 400
    wave = np.sqrt(2) * np.cos(np.linspace(0, np.pi, each))
    raw = rng.normal(0, noise, (lines, each + 4))
    off = sum(raw[:, i : i + each] for i in range(5)) / 5 + bend * wave
    found = misfit(off.ravel(), np.repeat(np.arange(lines), each), outlying=9.0)
    # A block of ten profiles, each the mean of five, has 0.084 of their variance, and shares 0.008 with the
    # next: of one less its neighbours' mean, over 1.5, 0.0733 is left.
    assert found.noise == pytest.approx(noise * np.sqrt(0.0733), rel=0.1)
    # What neighbours share looks like a bend of 0.38 of the noise at most. And a robust deviation sees a
    # wave's middling values: they lie between those of its crest and its zeros.
    assert bend * 0.7 <= found.bend <= bend * 1.6 + 0.5 * found.noise


def test_lines_too_short_tell_nothing() -> None:
    found = misfit(np.ones(30), np.repeat([0, 1], 15), outlying=9.0)
    assert (found.noise, found.bend, found.ratio) == (0.0, 0.0, 0.0)


def test_trust_follows_the_magnification_where_the_lens_departs() -> None:
    points, labels, _ = line_points(TRUTH)
    radius = np.linalg.norm(points - TRUTH[1:3], axis=1)
    much = trust_by_magnification(points, labels, TRUTH, ratio=100.0)
    none = trust_by_magnification(points, labels, TRUTH, ratio=0.0)
    assert much.mean() == pytest.approx(1.0)
    np.testing.assert_allclose(none, 1.0)
    assert much[radius > 250].mean() > 1.3 * much[radius < 100].mean()


def test_a_lens_of_another_kind_is_straightest_in_the_corrected_picture() -> None:
    """One parameter for a lens that has two: near the best that one can do, and the verdict says so."""
    scene = board(lam=-0.6e-6, lam2=-3.5e-11, square=34.0, noise=1.0)
    corners, seen = true_corners(scene)
    assert seen.all()

    def rms(x: np.ndarray) -> float:
        return straightness(corners, DivisionModel(x[0] * 1e-6, (x[1], x[2]), (640, 480)))

    best = minimize(rms, [-2.5, 325.0, 233.0], method="Nelder-Mead", options={"maxiter": 2000})
    found = calibrate(render_board(scene))
    assert best.fun > 0.2, "the lens must depart from the model for this to tell"
    assert straightness(corners, found.model) < 1.15 * best.fun
    assert found.quality.verdict == "doubtful"
    assert any("above noise" in reason for reason in found.quality.reasons)
    two = calibrate(render_board(scene), CalibrationSpec(model="division2"))
    assert straightness(corners, two.model) < 0.15 * best.fun
    assert not any("above noise" in reason for reason in two.quality.reasons)
