"""Frames that repeat the one before."""

from __future__ import annotations

import numpy as np
import pytest

from endocal.zoom.repeats import Repeats, RepeatSpec

from . import scenery


def told(*images: np.ndarray) -> list[bool]:
    repeats = Repeats()
    return [repeats.has(image) for image in images]


@pytest.mark.parametrize("depth", [8, 10, 16])
def test_repeats_are_told_at_any_depth(depth: int) -> None:
    dtype = np.uint8 if depth == 8 else np.uint16
    one, other = (scenery.picture(seed=s).astype(dtype) << (depth - 8) for s in (1, 2))
    assert told(one, one, other, other, one) == [False, True, False, True, False]


def test_a_repeat_that_was_coded_anew_is_one() -> None:
    shown = scenery.picture()
    # Here and there by a level.
    again = shown + np.random.default_rng(0).choice(np.array([0, 0, 0, 1], np.uint8), shown.shape)
    assert told(shown, again) == [False, True]


def test_what_moves_a_little_is_none() -> None:
    still = scenery.picture(seed=1)
    aside = scenery.picture(scenery.moved((0.002, 0.0)), seed=1)
    assert told(still, aside) == [False, False]


def test_black_repeats_nothing() -> None:
    black = np.full((360, 480), 6, np.uint8)
    assert told(black, black) == [False, False]


def test_what_stays_the_same_for_long_is_a_scene_at_rest() -> None:
    again = RepeatSpec().many
    assert told(*[scenery.picture()] * (2 * again + 2)) == [False, *[True] * again] * 2
