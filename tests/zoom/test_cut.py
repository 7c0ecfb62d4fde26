"""A scene that was cut, told from one that comes back after a flash or a blur."""

from __future__ import annotations

from itertools import pairwise

import cv2
import numpy as np
import pytest

from endocal.benchmarks.rim_frames import texture
from endocal.zoom.cut import CutDetector, CutSpec
from endocal.zoom.matching import evened, follow_places

SIZE = (320, 240)


def scene(seed: int, shift: float = 0.0) -> np.ndarray:
    """A picture of one of several scenes; the camera has gone on by ``shift`` px."""
    whole = (40 + 180 * texture(np.random.default_rng(seed), (500, 240), 1.2)).astype(np.uint8)
    matrix = np.array([[1.0, 0.0, -shift], [0.0, 1.0, 0.0]])
    return np.asarray(cv2.warpAffine(whole, matrix, SIZE), np.uint8)


def cuts(frames: list[np.ndarray], spec: CutSpec = CutSpec()) -> list[int]:
    """The frames at which a cut is told."""
    detector, told = CutDetector(spec), []
    for index, (last, current) in enumerate(pairwise(frames), 1):
        corners = cv2.goodFeaturesToTrack(last, 100, 0.005, 12, blockSize=5)
        places = np.empty((0, 1, 2), np.float32) if corners is None else corners
        found = np.zeros(0, np.bool_)
        if len(places):
            _, found = follow_places(last, current, np.asarray(places, np.float32))
        if detector.take(last, np.asarray(places, np.float32), current, found):
            told.append(index)
    return told


def moving(seed: int, count: int, start: int = 0) -> list[np.ndarray]:
    return [scene(seed, 2.0 * i) for i in range(start, start + count)]


def test_a_cut_is_told_once_when_the_scene_has_had_time_to_come_back() -> None:
    assert cuts(moving(1, 8) + moving(2, 20)) == [8 + CutSpec().frames]


def test_a_scene_that_goes_on_is_not_cut() -> None:
    assert not cuts(moving(1, 30))


@pytest.mark.parametrize("level", [0, 255])
def test_a_scene_that_comes_back_is_not_cut(level: int) -> None:
    nothing = [np.full(SIZE[::-1], level, np.uint8)] * 3
    assert not cuts(moving(1, 8) + nothing + moving(1, 20, start=11))


def test_of_pictures_that_are_not_alike_either_nothing_is_said() -> None:
    assert not cuts(moving(1, 8) + [scene(seed) for seed in range(10, 30)])


def test_another_light_hardly_changes_an_evened_picture() -> None:
    bright = scene(1)
    dim = np.asarray(bright * 0.4 + 60, np.uint8)
    assert np.abs(evened(dim).astype(int) - evened(bright)).mean() < 2
    assert not evened(np.full((4, 4), 7, np.uint8)).std()
