"""The reach of the visible content against a count over all pixels."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from endocal.boundary.circle import Boundary
from endocal.boundary.content import content_radius
from endocal.errors import InputError

SIZE = (40, 30)


@given(
    center=st.tuples(st.floats(-5, 45), st.floats(-5, 35)),
    circle=st.tuples(st.floats(-5, 45), st.floats(-5, 35)),
    radius=st.floats(9, 60),
    aspect=st.sampled_from([1.0, 1.4, 0.8]),
)
def test_it_is_the_farthest_pixel_in_the_circle(
    center: tuple[float, float], circle: tuple[float, float], radius: float, aspect: float
) -> None:
    y, x = np.mgrid[0 : SIZE[1], 0 : SIZE[0]]
    inside = np.hypot((x - circle[0]) * aspect, y - circle[1]) <= radius
    far = np.hypot((x - center[0]) * aspect, y - center[1])[inside].max(initial=0)
    boundary = Boundary(circle, 2 * radius, 1.0, 1.0)
    reach = content_radius(center, SIZE, boundary, aspect)
    # The farthest point of the region lies within a pixel's diagonal of the farthest pixel in it.
    assert far - 1e-9 <= reach <= far + math.hypot(aspect, 1) + 1e-9


def test_without_a_circle_it_is_the_farthest_corner() -> None:
    assert content_radius((0, 0), SIZE) == pytest.approx(math.hypot(39, 29))
    assert content_radius((30, 20), SIZE, pixel_aspect=2.0) == pytest.approx(math.hypot(60, 20))


def test_a_circle_about_the_centre_reaches_its_radius() -> None:
    boundary = Boundary((20.0, 15.0), 20.0, 314.0, 1.0)
    assert content_radius((20.0, 15.0), SIZE, boundary) == pytest.approx(10)
    assert content_radius((17.0, 11.0), SIZE, boundary) == pytest.approx(15)


def test_a_circle_beside_the_frame_is_refused() -> None:
    with pytest.raises(InputError, match="outside the 40x30 frame"):
        content_radius((20.0, 15.0), SIZE, Boundary((100.0, 15.0), 20.0, 1.0, 0.0))
