"""A hand is expected to come nearer as it goes aside, and hardly where it stands still."""

from __future__ import annotations

import numpy as np
import pytest

from endocal.zoom.hand import Hand, HandSpec

FRAME = 0.04


def seen(speed: float, seconds: float, hand: Hand | None = None) -> Hand:
    """A hand that goes aside at this speed."""
    hand = hand or Hand()
    for _ in range(round(seconds / FRAME)):
        hand.learn(np.full(2, speed), FRAME)
    return hand


def test_the_usual_hand_is_expected_at_first() -> None:
    assert Hand().speed == pytest.approx(0.07, rel=0.05)


def test_a_camera_that_stands_still_is_hardly_expected_to_come_nearer() -> None:
    # The longer it stands the less; seen of late alone it would be as good as just come to rest.
    assert seen(0.0, 3).speed < 0.03
    assert seen(0.0, 20).speed < 0.015


@pytest.mark.parametrize("still", [0.0, 20.0])
def test_a_camera_that_sets_out_to_roam_is_expected_to_come_nearer_at_once(still: float) -> None:
    hand = seen(0.0, still)
    assert seen(0.3, 2, hand).speed > 0.2


def test_ways_are_all_there_are() -> None:
    ways = Hand(HandSpec(hurry=0.1, freely=0.3)).ways
    assert sum(probability for _, probability in ways) == pytest.approx(1)
    assert [speed for speed, _ in ways] == sorted(speed for speed, _ in ways)


def test_what_it_did_is_told_apart_from_what_is_expected_of_it() -> None:
    assert Hand().aside == 0
    assert seen(0.0, 1).aside == 0
    assert seen(0.04, 10).aside == pytest.approx(0.04)
