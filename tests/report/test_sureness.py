"""How surely a point is placed: against many draws of the parameters."""

from __future__ import annotations

import numpy as np
import pytest

from endocal.calibration.outcome import Workings
from endocal.model import DivisionModel
from endocal.report.sureness import placing_sigma, undistorted


@pytest.mark.parametrize("lam2", [0.0, 3e-12])
def test_it_is_the_spread_over_draws_of_the_parameters(lam2: float) -> None:
    model = DivisionModel(-3e-6, (370.0, 260.0), (720, 540), lam2=lam2)
    params = np.array([model.lam, *model.center, *([lam2] if lam2 else [])])
    rng = np.random.default_rng(1)
    mix = (
        rng.normal(size=(len(params), len(params)))
        * np.array([3e-9, 0.1, 0.1, 2e-14])[: len(params), None]
    )
    covariance = mix @ mix.T
    points = np.array([[370.0, 260.0], [100.0, 80.0], [600.0, 500.0]])
    draws = rng.multivariate_normal(params, covariance, 4000)
    placed = np.stack([undistorted(points, draw) for draw in draws])
    spread = np.sqrt(placed.var(axis=0).sum(axis=1))
    workings = Workings(None, None, covariance=covariance)  # type: ignore[arg-type]
    found = placing_sigma(workings, model, points)
    # 4000 draws know a standard deviation to about 1.6 %.
    assert found == pytest.approx(spread, rel=0.08, abs=1e-6)


def test_undistorted_is_the_model() -> None:
    model = DivisionModel(-3e-6, (370.0, 260.0), (720, 540), lam2=1e-12)
    points = np.array([[0.0, 0.0], [719.0, 100.0], [370.0, 260.0]])
    assert undistorted(points, np.array([-3e-6, 370.0, 260.0, 1e-12])) == pytest.approx(
        model.undistort(points)
    )
