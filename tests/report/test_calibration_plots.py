"""What the plots of a calibration show, from truths made here."""

from __future__ import annotations

import numpy as np
import pytest

from endocal.report.calibration import NEIGHBOURS, smoothed
from endocal.report.calibration_plots import spread_over_frame
from endocal.report.numbers import duration, percent, scientific


def test_the_map_finds_the_corner_that_is_worse() -> None:
    rng = np.random.default_rng(5)
    points = rng.uniform((0, 0), (720, 540), (60_000, 2))
    sigma = np.where((points[:, 0] < 180) & (points[:, 1] > 360), 0.3, 0.05)
    residuals = rng.normal(0, sigma)
    # One point in a hundred is on no line: a robust measure does not see it.
    residuals[::100] += 20
    x, y, spread = spread_over_frame(points, residuals, (720.0, 540.0))
    assert spread.shape == (len(y) - 1, len(x) - 1) == (18, 24)
    corner = np.zeros_like(spread, bool)
    corner[12:, :6] = True
    # Some 140 points a cell know their standard deviation to about 10 %.
    assert spread[corner] == pytest.approx(0.3, rel=0.45)
    assert spread[~corner] == pytest.approx(0.05, rel=0.45)


def test_where_there_is_no_point_there_is_no_colour() -> None:
    points = np.array([[10.0, 10.0], [11.0, 11.0], [12.0, 12.0], [719.0, 539.0]])
    _, _, spread = spread_over_frame(points, np.array([0.1, -0.1, 0.1, 9.0]), (720.0, 540.0))
    assert np.isfinite(spread).sum() == 1
    assert spread[0, 0] == pytest.approx(0.1 / 0.6745)


def test_lines_show_their_bends_and_not_their_noise() -> None:
    n = 200
    labels = np.repeat([0, 1], n)
    bend = np.where(np.arange(2 * n) < n, 0.0, 0.5 * np.sin(np.linspace(0, np.pi, 2 * n)))
    noise = np.random.default_rng(1).normal(0, 0.05, 2 * n)
    spikes = np.zeros(2 * n)
    spikes[:: NEIGHBOURS * 2] = 5.0
    out = smoothed(bend + noise + spikes, labels)
    # The median of 11 points has 0.38 of the standard deviation of one.
    assert np.abs(out - bend).max() < 5 * 0.38 * 0.05


@pytest.mark.parametrize(
    ("value", "sigma", "number", "spread"),
    [
        (-4.680234e-6, 7.8e-10, "−4.68023·10⁻⁶", "± 0.00078·10⁻⁶"),
        (-1.287e-5, 5.4e-7, "−1.287·10⁻⁵", "± 0.054·10⁻⁵"),
        (2e-13, None, "2.0000·10⁻¹³", ""),
        (-1.29991, None, "−1.2999", ""),
        (0.0, 1e-9, "0", "± 1e-09"),
    ],
)
def test_numbers_as_people_write_them(
    value: float, sigma: float | None, number: str, spread: str
) -> None:
    assert scientific(value, sigma) == (number, spread)


def test_shares_and_times() -> None:
    assert percent(-0.0012) == "−0.12\u202f%"
    assert percent(0.2) == "+20.0\u202f%"
    times = {0.04: "0.04 s", 4.2: "4.2 s", 185: "3 min 05 s", 3720: "1 h 02 min"}
    assert [duration(seconds) for seconds in times] == list(times.values())
