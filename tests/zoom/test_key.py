"""Places of a key picture, found again in later ones whose zoom and camera are known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from endocal.zoom.key import KeyPicture
from endocal.zoom.likeness import Likeness

from . import scenery


def matched(
    zoom: float,
    homography: np.ndarray,
    expected: tuple[np.ndarray, float],
    scene: np.ndarray = scenery.SCENE,
):
    """Match the first picture of a scene in a later one; ``expected`` is what the steps made of it."""
    key = KeyPicture(scenery.picture(), scenery.view())
    key.go_on(*expected)
    now = scenery.picture(homography, zoom, scene, seed=1)
    view = scenery.view(scenery.DIAMETER * math.exp(key.motion.logarithm))
    fit = key.match(now, view, (0.0, 0.0), 1.0, Likeness(6.0))
    return key, fit


@pytest.mark.parametrize(
    ("zoom", "aside"), [(0.0, (0.0, 0.0)), (0.3, (0.01, -0.02)), (-0.2, (0.03, 0.0))]
)
def test_the_zoom_since_the_key_is_told_though_the_steps_were_off(
    zoom: float, aside: tuple[float, float]
) -> None:
    homography = scenery.moved(aside)
    generator = np.zeros((3, 3))
    generator[:2, 2] = np.array(aside) + 0.002
    key, fit = matched(zoom, homography, (generator, 0.9 * zoom))
    assert fit is not None
    assert key.found > 60
    assert fit.motion.logarithm == pytest.approx(zoom, abs=max(4 * fit.sigma, 1e-3))
    assert fit.motion.logarithm == pytest.approx(zoom, abs=0.01)
    assert key.motion == fit.motion


def test_another_scene_is_not_found() -> None:
    key, fit = matched(0.0, np.eye(3), (np.zeros((3, 3)), 0.0), scenery.OTHER_SCENE)
    assert fit is None
    assert key.found < 24
    assert key.motion.logarithm == 0


def test_places_that_left_the_picture_are_not_sought() -> None:
    generator = np.zeros((3, 3))
    generator[0, 2] = 0.9
    key, fit = matched(0.0, scenery.moved((0.9, 0.0)), (generator, 0.0))
    assert fit is None
    assert key.found == 0


def test_a_picture_of_nothing_makes_a_key_that_tells_nothing() -> None:
    key = KeyPicture(np.full(scenery.SIZE[::-1], 90, np.uint8), scenery.view())
    assert key.match(scenery.picture(), scenery.view(), (0.0, 0.0), 1.0, Likeness(6.0)) is None
    assert key.found == 0
