"""What a picture shows outside the circle that was seen last."""

from __future__ import annotations

import numpy as np
import pytest

from endocal.boundary.circle import Boundary
from endocal.zoom.outside import SeenCircle

MIDDLE = (241.0, 178.0)


def shown(
    diameter: float, light: float = 120.0, black: float = 6.0, aspect: float = 1.0
) -> np.ndarray:
    """A picture within a circle, with noise, (360, 480)."""
    y, x = np.mgrid[0:360, 0:480]
    inside = np.hypot((x - MIDDLE[0]) * aspect, y - MIDDLE[1]) < diameter / 2
    noise = np.random.default_rng(0).normal(0, 2, inside.shape)
    return np.clip(np.where(inside, light, black) + noise, 0, 255).astype(np.uint8)


def seen(diameter: float, aspect: float = 1.0) -> SeenCircle:
    """What was seen of such a circle."""
    circle = Boundary(MIDDLE, diameter, 0.0, 1.0)
    return SeenCircle(shown(diameter, aspect=aspect), circle, aspect)


@pytest.mark.parametrize("aspect", [1.0, 1.4])
def test_a_picture_that_fills_the_frame_shows_more_than_a_small_circle(aspect: float) -> None:
    assert seen(300, aspect).is_outgrown(shown(900), 300)
    # Up to where the circle that is claimed leaves the frame itself.
    assert not seen(300, aspect).is_outgrown(shown(900), 640 * aspect)


@pytest.mark.parametrize(
    "now", [shown(300), shown(330), shown(300, light=6), shown(300, black=25), shown(900, light=6)]
)
def test_black_about_the_circle_is_no_more(now: np.ndarray) -> None:
    assert not seen(300).is_outgrown(now, 300)


def test_a_panel_beside_the_circle_is_no_more() -> None:
    now = shown(300)
    now[:, 420:] = 160
    assert not seen(300).is_outgrown(now, 300)


def test_a_circle_that_left_no_black_tells_nothing() -> None:
    assert not seen(590).is_outgrown(shown(900), 300)
