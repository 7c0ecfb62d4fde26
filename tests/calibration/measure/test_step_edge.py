import numpy as np
import pytest
from scipy.special import ndtr

from endocal.calibration.measure.step_edge import NARROWEST, STRETCH, WIDEST, Steps, fit_steps

X = np.arange(-WIDEST, WIDEST + 1)


def steps_of(levels: np.ndarray) -> Steps:
    """Steps of profiles along one line."""
    return fit_steps(levels, np.zeros(len(levels), np.intp))


def profiles(
    offsets: np.ndarray, width: float, low: float = 20.0, height: float = 100.0
) -> np.ndarray:
    return low + height * ndtr((X - offsets[:, None]) / width)


@pytest.mark.parametrize("width", [0.9, 1.3, 2.0, 2.8])
def test_steps_are_found_where_they_are(width: float) -> None:
    offsets = np.linspace(-1.2, 1.2, 49)
    steps = steps_of(profiles(offsets, width))
    assert steps.offsets == pytest.approx(offsets, abs=0.01)
    assert steps.heights == pytest.approx(100, rel=0.05)
    assert steps.near.all()
    assert ((steps.reach >= NARROWEST) & (steps.reach <= WIDEST)).all()


def test_a_falling_step_has_a_negative_height() -> None:
    steps = steps_of(np.concatenate([profiles(np.zeros(3), 1.2), 140 - profiles(np.zeros(3), 1.2)]))
    assert np.sign(steps.heights).tolist() == [1, 1, 1, -1, -1, -1]


def test_a_step_beyond_the_window_is_not_near() -> None:
    steps = steps_of(profiles(np.array([0.0, 0.1, -0.1, 4.0]), 1.0))
    assert steps.near.tolist() == [True, True, True, False]


def test_noise_moves_it_hardly_more_than_it_must() -> None:
    """White noise moves a step of width s and height h by a variance of 2 sqrt(pi) s / h^2 at least.

    That bound is for levels that are known; here those beside the step are told from a few px.
    """
    rng = np.random.default_rng(2)
    width, height = 1.9, 100.0
    clean = profiles(np.zeros(4000), width, height=height)
    steps = steps_of(clean + rng.normal(0, 6.0, clean.shape))
    bound = 6.0 / height * np.sqrt(2 * np.sqrt(np.pi) * width)
    assert steps.offsets.std() < 1.7 * bound


def test_other_edges_nearby_are_not_looked_at() -> None:
    """Bars 10 px wide: beyond 5 px from an edge the levels are those of the next one."""
    offsets = np.linspace(-0.4, 0.4, 41)
    bars = sum(s * profiles(offsets + at, 1.2) for s, at in ((1, 0.0), (-1, 10.0), (-1, -10.0)))
    steps = steps_of(bars)
    assert (steps.reach <= 5).all()
    assert steps.offsets == pytest.approx(offsets, abs=0.01)


def test_each_stretch_of_a_line_is_looked_at_as_far_as_its_own_neighbours_allow() -> None:
    """Bars seen 7 px wide at one end of their edges and 40 px at the other, and an edge on its own."""
    offsets = np.linspace(-0.3, 0.3, 2 * STRETCH)
    widths = np.repeat([7.0, 40.0], STRETCH)
    bars = sum(s * profiles(offsets + at * widths, 1.7) for s, at in ((1, 0), (-1, 1), (-1, -1)))
    alone = profiles(offsets[:5], 1.7)
    owner = np.repeat([0, 1], [len(bars), len(alone)])
    steps = fit_steps(np.concatenate([bars, alone]), owner)
    assert (steps.reach[:STRETCH] <= 4).all()
    assert (steps.reach[STRETCH:] > 4).all()
    # Bars of four widths of the blur melt into each other a little.
    assert steps.offsets[:STRETCH] == pytest.approx(offsets[:STRETCH], abs=0.06)
    assert steps.offsets[STRETCH : 2 * STRETCH] == pytest.approx(offsets[STRETCH:], abs=0.01)
