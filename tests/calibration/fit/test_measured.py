"""What is stated of a fit to measured points."""

from __future__ import annotations

import numpy as np
import pytest

from endocal.calibration.fit.measured import Refined
from endocal.calibration.fit.plumb_line import Fit, Prior, fit_model
from endocal.calibration.fit.uncertainty import covariance

from ..sheets import LENS, board

PRIOR = Prior((319.5, 239.5), (32.0, 24.0))


def refined(noise: float) -> tuple[Refined, Fit]:
    m = board(noise=noise)
    fit = fit_model(m.points, m.labels, LENS, 330.0, PRIOR, 0.05, m.sides)
    return Refined(fit, m, np.zeros(len(m.points), np.intp), True), fit


@pytest.mark.parametrize("noise", [1e-4, 0.05])
def test_lambda_is_never_surer_than_a_hundredth_of_a_pixel_at_the_farthest_points(
    noise: float,
) -> None:
    whole, fit = refined(noise)
    reach = np.linalg.norm(whole.measured.points - fit.params[1:3], axis=1).max()
    told = covariance(fit, whole.measured.labels)
    sigma = np.sqrt(whole.covariance[0, 0])
    assert sigma == pytest.approx(np.hypot(np.sqrt(told[0, 0]), 0.01 / reach**3), rel=1e-9)
    np.testing.assert_allclose(whole.covariance[1:, :], told[1:, :], rtol=1e-9)
