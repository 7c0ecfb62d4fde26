"""The stated uncertainty of a circle whose rim is slightly elliptic."""

from __future__ import annotations

import math

import numpy as np
import pytest

from endocal.boundary.departure import RimPoints, radius_departure
from endocal.boundary.fit import bearings, fit_offsets
from endocal.boundary.rim import angles

RADIUS = 500.0


def fitted_arc(
    seed: int, arc: float, ellipse: float = 0.0033, noise: float = 0.2
) -> tuple[float, float, float]:
    """Fit a circle to an arc, in radians, of a rim with waves.

    Returns the radius's error, its sigma, and that of independent rim points, px. ``ellipse`` is the
    amplitude of the second wave, of the radius; the finer ones fall with its third power.
    """
    rng = np.random.default_rng(seed)
    angle = angles()[angles() < arc]
    waves = np.arange(2, 9)
    size = ellipse * RADIUS * (2 / waves) ** 3 * rng.rayleigh(math.sqrt(0.5), len(waves))
    phase = rng.uniform(0, 2 * np.pi, len(waves))
    offset = size @ np.cos(np.outer(waves, angle) + phase[:, None])
    offset = (offset + rng.normal(0, noise, len(angle))).astype(np.float32)
    used = np.ones(len(angle), np.bool_)
    fitted = fit_offsets(bearings(angle), offset, used, 0.2, 3.0)
    assert fitted is not None
    departure = radius_departure(RimPoints(angle, used, offset, fitted), RADIUS)
    sigma = fitted.radius_sigma
    return fitted.by.radius, math.hypot(sigma, departure), sigma


@pytest.mark.parametrize("degrees", [80, 140, 220, 300])
def test_the_error_of_an_arc_is_as_large_as_stated(degrees: float) -> None:
    found = np.array([fitted_arc(seed, math.radians(degrees)) for seed in range(200)])
    assert 0.6 < np.sqrt(np.mean((found[:, 0] / found[:, 1]) ** 2)) < 1.4
    # What independent points would leave is far too little.
    assert np.sqrt(np.mean((found[:, 0] / found[:, 2]) ** 2)) > 3


def test_a_whole_rim_is_known_whatever_its_shape() -> None:
    error, sigma, independent = fitted_arc(1, 2 * math.pi)
    assert abs(error) < 0.2
    assert sigma < 1.5 * independent


def test_a_rim_that_shows_no_waves_is_trusted_more() -> None:
    round_, wavy = (
        np.mean([fitted_arc(seed, math.radians(300), e)[1] for seed in range(20)])
        for e in (0.0, 0.0066)
    )
    assert round_ < wavy / 2
