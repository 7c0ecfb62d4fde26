"""Places along lines, where the points of a lens that departs from the model run."""

from __future__ import annotations

import numpy as np

from endocal.calibration.measure.courses import FOLLOWED, courses

# No distortion: what is straight in the picture are lines.
FLAT = np.array([0.0, 300.0, 100.0])


def wave(x: np.ndarray) -> np.ndarray:
    """How far a line runs from the model's, px."""
    return np.asarray(2 * np.cos(2 * np.pi * x / 400))


def test_places_follow_where_points_run() -> None:
    x = np.arange(100.0, 500.0)
    points = np.concatenate([np.stack([x, y + wave(x)], axis=1) for y in (60.0, 140.0)])
    labels = np.repeat([0, 1], len(x))
    along = courses(points, labels, FLAT, follow=True)
    # A bin's median stands for its middle; beyond those of the first and the last nothing is known.
    inner = (along.at[:, 0] > 100 + FOLLOWED) & (along.at[:, 0] < 500 - FOLLOWED)
    at, owner = along.at[inner], along.owner[inner]
    assert np.bincount(owner).min() > 350
    off = at[:, 1] - np.array([60.0, 140.0])[owner] - wave(at[:, 0])
    # What is straight from one median to the next is 0.03 px off at most.
    assert np.abs(off).max() < 0.03


def test_else_they_lie_where_the_model_has_them() -> None:
    x = np.arange(100.0, 500.0)
    along = courses(
        np.stack([x, 60 + wave(x)], axis=1), np.zeros(len(x), np.intp), FLAT, follow=False
    )
    straight = np.polynomial.Polynomial.fit(*along.at.T, 1)
    np.testing.assert_allclose(straight(along.at[:, 0]), along.at[:, 1], atol=1e-9)
