"""Interpolation between a few knots against numpy and against its own promises."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from endocal.zoom.interpolate import MonotoneCurve, line_slope, linear

knots = st.lists(st.tuples(st.floats(1, 20), st.floats(-5, 5)), min_size=2, max_size=6).map(
    lambda steps: (list(np.cumsum([s for s, _ in steps])), [v for _, v in steps])
)


@given(knots=knots, at=st.floats(-10, 150))
def test_linear_is_numpys(knots: tuple[list[float], list[float]], at: float) -> None:
    assert linear(*knots, at) == pytest.approx(np.interp(at, *knots), abs=1e-9)


@given(knots=knots)
def test_slope_is_the_least_squares_lines(knots: tuple[list[float], list[float]]) -> None:
    assert line_slope(*knots) == pytest.approx(np.polyfit(*knots, 1)[0], abs=1e-9)


@given(knots=knots)
def test_the_curve_meets_its_knots_and_stays_between_them(
    knots: tuple[list[float], list[float]],
) -> None:
    x, y = knots
    curve = MonotoneCurve(x, y)
    assert [curve(v) for v in x] == pytest.approx(y, abs=1e-9)
    for i in range(len(x) - 1):
        values = [curve(v) for v in np.linspace(x[i], x[i + 1], 50)]
        assert min(values) >= min(y[i : i + 2]) - 1e-9
        assert max(values) <= max(y[i : i + 2]) + 1e-9
        # Monotone: all steps in the direction from one knot to the next.
        steps = np.diff(values) * np.sign(y[i + 1] - y[i])
        assert steps.min() >= -1e-9
