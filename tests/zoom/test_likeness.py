"""Errors of places' own, errors that neighbours share, and errors that last are told from one another."""

from __future__ import annotations

import numpy as np
import pytest

from endocal.zoom.likeness import Likeness

SIZE = np.array([640.0, 360.0])


def learned(shared: float = 0.0, lasts: bool = False, recoils: bool = False) -> Likeness:
    """60 steps of 150 places with errors of their own, and so much of patches of 160x120 px besides.

    The patches' ``lasts`` from step to step, or is another each time; the places' own ``recoils`` when a
    place that was put wrongly is put right, or is another each time.
    """
    rng, likeness = np.random.default_rng(7), Likeness(25.0)
    places = rng.uniform(0, SIZE, (150, 2))
    patch = (places // (160, 120)).astype(int) @ (1, 4)
    common = rng.normal(0, shared, (12, 2))
    last = rng.normal(0, 1, (150, 2))
    for _ in range(60):
        own = rng.normal(0, 1, (150, 2))
        error = (own - last if recoils else own) + common[patch]
        last = own
        if not lasts:
            common = rng.normal(0, shared, (12, 2))
        likeness.learn(places, error, np.ones(150))
    return likeness


def test_nothing_is_known_before_the_first_step() -> None:
    likeness = Likeness(25.0)
    assert likeness.alike is None
    assert likeness.lasting is None
    likeness.learn(np.zeros((30, 2)), np.ones((30, 2)), np.ones(30))
    assert likeness.alike is not None
    # One step alone says nothing of the next.
    assert likeness.lasting is None


@pytest.mark.parametrize("recoils", [False, True])
def test_errors_of_their_own_are_not_alike(recoils: bool) -> None:
    likeness = learned(recoils=recoils)
    assert likeness.alike == pytest.approx(0, abs=0.02)
    assert likeness.lasting == pytest.approx(0, abs=0.02)


def test_what_neighbours_share_may_last_or_be_another_in_each_step() -> None:
    lasting, passing = learned(0.5, lasts=True), learned(0.5)
    # Half a deviation in common: 0.25 of 1.25.
    assert lasting.alike == pytest.approx(0.2, abs=0.08)
    assert passing.alike == pytest.approx(0.2, abs=0.08)
    assert lasting.lasting == pytest.approx(0.2, abs=0.08)
    assert passing.lasting == pytest.approx(0, abs=0.04)


def test_what_does_not_fit_the_motion_does_not_count() -> None:
    rng, likeness = np.random.default_rng(7), Likeness(25.0)
    places = rng.uniform(0, SIZE, (150, 2))
    moves_alone = places[:, 0] < 200
    for _ in range(60):
        error = rng.normal(0, 1, (150, 2)) + np.where(moves_alone, 20.0, 0.0)[:, None]
        likeness.learn(places, error, np.where(moves_alone, 0.0, 1.0))
    assert likeness.lasting == pytest.approx(0, abs=0.02)
