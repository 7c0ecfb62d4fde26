import numpy as np
import pytest
from scipy.special import ndtr

from endocal.calibration.step_edge import NARROWEST, WIDEST, fit_steps

X = np.arange(-WIDEST, WIDEST + 1)


def profiles(
    offsets: np.ndarray, width: float, low: float = 20.0, height: float = 100.0
) -> np.ndarray:
    return low + height * ndtr((X - offsets[:, None]) / width)


@pytest.mark.parametrize("width", [0.9, 1.3, 2.0, 2.8])
def test_steps_are_found_where_they_are(width: float) -> None:
    offsets = np.linspace(-1.2, 1.2, 49)
    steps = fit_steps(profiles(offsets, width))
    assert steps.offsets == pytest.approx(offsets, abs=0.01)
    assert steps.heights == pytest.approx(100, rel=0.05)
    assert steps.near.all()
    assert NARROWEST <= steps.reach <= WIDEST


def test_a_falling_step_has_a_negative_height() -> None:
    steps = fit_steps(
        np.concatenate([profiles(np.zeros(3), 1.2), 140 - profiles(np.zeros(3), 1.2)])
    )
    assert np.sign(steps.heights).tolist() == [1, 1, 1, -1, -1, -1]


def test_a_step_beyond_the_window_is_not_near() -> None:
    steps = fit_steps(profiles(np.array([0.0, 0.1, -0.1, 4.0]), 1.0))
    assert steps.near.tolist() == [True, True, True, False]


def test_noise_moves_it_hardly_more_than_it_must() -> None:
    """White noise moves a step of width s and height h by a variance of 2 sqrt(pi) s / h^2 at least.

    That bound is for levels that are known; here those beside the step are told from a few px.
    """
    rng = np.random.default_rng(2)
    width, height = 1.9, 100.0
    clean = profiles(np.zeros(4000), width, height=height)
    steps = fit_steps(clean + rng.normal(0, 6.0, clean.shape))
    bound = 6.0 / height * np.sqrt(2 * np.sqrt(np.pi) * width)
    assert steps.offsets.std() < 1.7 * bound


def test_other_edges_nearby_are_not_looked_at() -> None:
    """Bars 10 px wide: beyond 5 px from an edge the levels are those of the next one."""
    offsets = np.linspace(-0.4, 0.4, 41)
    bars = sum(s * profiles(offsets + at, 1.2) for s, at in ((1, 0.0), (-1, 10.0), (-1, -10.0)))
    steps = fit_steps(bars)
    assert steps.reach <= 5
    assert steps.offsets == pytest.approx(offsets, abs=0.01)
