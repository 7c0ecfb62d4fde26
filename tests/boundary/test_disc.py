"""The disc in a frame against counting."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from endocal.boundary.disc import Box, disc_area, visible_fraction
from endocal.boundary.fit import Circle

circles = st.builds(Circle, st.floats(-10, 50), st.floats(-10, 40), st.floats(3, 60))


@given(circle=circles)
def test_area_is_the_count_of_small_cells(circle: Circle) -> None:
    step = 0.1
    x, y = np.arange(0, 40, step) + step / 2, np.arange(0, 30, step) + step / 2
    inside = np.hypot(x - circle.x, y[:, None] - circle.y) <= circle.radius
    # Each cell on the rim may be counted wrong by half its area.
    tolerance = 2 * np.pi * circle.radius * step
    assert disc_area(circle, Box(0, 0, 40, 30)) == pytest.approx(
        inside.sum() * step**2, abs=tolerance
    )


@given(circle=circles)
def test_visible_fraction_is_the_count_of_directions(circle: Circle) -> None:
    angle = (np.arange(7200) + 0.5) * (2 * np.pi / 7200)
    x = circle.x + circle.radius * np.cos(angle)
    y = circle.y + circle.radius * np.sin(angle)
    inside = (x >= 0) & (x <= 40) & (y >= 0) & (y <= 30)
    assert visible_fraction(circle, Box(0, 0, 40, 30)) == pytest.approx(inside.mean(), abs=2e-3)
