"""Grey levels between the pixels."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ndtr

from endocal.calibration.image.sampling import (
    from_reduced,
    reduced,
    sample,
    sample_smoothly,
    to_reduced,
)

SIZE, BLUR = 40, 1.2


@pytest.mark.parametrize("sampler", [sample, sample_smoothly])
def test_what_rises_evenly_is_kept(sampler) -> None:  # type: ignore[no-untyped-def]
    y, x = np.mgrid[:SIZE, :SIZE]
    points = np.random.default_rng(3).uniform(3, SIZE - 4, (50, 2))
    seen = sampler((2 * x + 3 * y).astype(np.float32), points)
    # To the 32nd of a pixel that ``sample`` rounds to.
    np.testing.assert_allclose(seen, points @ [2, 3], atol=5 / 64 + 1e-3)


@pytest.mark.parametrize("phase", [0.0, 0.13, 0.25, 0.41, 0.5, 0.8])
def test_an_edge_is_smoothed_alike_wherever_it_lies(phase: float) -> None:
    """By a third of a px^2, and about its own place."""
    at = 20 + phase
    picture = np.tile(ndtr((np.arange(SIZE) - at) / BLUR).astype(np.float32), (SIZE, 1))
    offsets = np.linspace(-3, 3, 13)
    points = np.stack([at + offsets, np.full(len(offsets), 20.3)], axis=1)
    expected = ndtr(offsets / np.sqrt(BLUR**2 + 1 / 3))
    np.testing.assert_allclose(sample_smoothly(picture, points), expected, atol=2e-3)
    np.testing.assert_allclose(sample_smoothly(picture, points)[6], 0.5, atol=5e-4)


def test_points_keep_their_shape_and_those_outside_see_the_border() -> None:
    picture = np.outer(np.arange(SIZE), np.ones(SIZE)).astype(np.float32)
    seen = sample_smoothly(
        picture, np.array([[[5.0, 7.0], [5.0, -9.0]], [[99.0, 7.0], [5.0, 99.0]]])
    )
    assert seen.shape == (2, 2)
    assert seen.dtype == np.float32
    np.testing.assert_allclose(seen, [[7, 0], [7, SIZE - 1]], atol=1e-5)


def test_a_reduced_picture_shows_a_point_where_it_is_said_to_lie() -> None:
    y, x = np.mgrid[:41, :38]
    picture = (2 * x + 3 * y).astype(np.float32)
    small = reduced(picture, 3)
    assert small.shape == (13, 12)
    points = np.random.default_rng(4).uniform(3, 33, (50, 2))
    seen = sample(small, to_reduced(points, 3))
    np.testing.assert_allclose(seen, points @ [2, 3], atol=3 * 5 / 64 + 1e-3)
    np.testing.assert_allclose(from_reduced(to_reduced(points, 3), 3), points)
    assert reduced(picture, 1) is picture
