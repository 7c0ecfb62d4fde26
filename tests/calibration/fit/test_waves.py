"""The spectrum of what a fit leaves, told from the waves along lines."""

from __future__ import annotations

import numpy as np
import pytest

from endocal.calibration.fit.waves import Waves

NOISE = 0.3


def left_by_lines(*lengths: int) -> tuple[np.ndarray, np.ndarray]:
    """White noise along lines, (n,), less what each line's place and direction follow, and labels (n,)."""
    rng = np.random.default_rng(1)
    parts = []
    for n in lengths:
        basis = np.linalg.qr(np.stack([np.ones(n), np.linspace(-1, 1, n)], axis=1))[0]
        off = rng.normal(0, NOISE, n)
        parts.append(off - basis @ (basis.T @ off))
    return np.concatenate(parts), np.repeat(np.arange(len(lengths)), lengths)


def test_white_noise_is_white_to_its_slowest_waves() -> None:
    """What lines' own places take of it is made up for, and is no lack of slow waves in longer lines."""
    residuals, labels = left_by_lines(*[60, 120] * 200)
    waves = Waves.of(residuals, np.zeros((len(labels), 1)), labels)
    power = waves.power(waves.heights, waves.left(np.zeros((1, 1))))
    for number in (2, 3, 8, 30, 59):
        assert power[waves.number == number].mean() == pytest.approx(NOISE**2, rel=0.15)


def test_slow_waves_alone_are_those_of_all() -> None:
    residuals, labels = left_by_lines(60, 20, 90)
    weights = np.random.default_rng(2).uniform(0.5, 1, len(labels))
    waves = Waves.of(weights * residuals, np.zeros((len(labels), 1)), labels)
    alone = waves.slow_ones_of(residuals[:, None], weights)
    np.testing.assert_allclose(alone[:, 0], waves.heights[waves.slow], atol=1e-12)
