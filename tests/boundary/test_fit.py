"""Circles through points, with points that lie elsewhere."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from endocal.boundary.fit import bearings, consensus_circle, fit_offsets


@given(
    x=st.floats(50, 150),
    y=st.floats(50, 150),
    radius=st.floats(40, 90),
    stray=st.floats(0, 0.4),
    seed=st.integers(0, 99),
)
def test_the_consensus_is_the_circle_that_most_points_lie_on(
    x: float, y: float, radius: float, stray: float, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    angle = rng.uniform(0, 2 * np.pi, 200)
    px, py = x + radius * np.cos(angle), y + radius * np.sin(angle)
    off = rng.random(200) < stray
    px[off], py[off] = rng.uniform(0, 200, (2, int(off.sum())))
    px, py = px + rng.normal(0, 0.3, 200), py + rng.normal(0, 0.3, 200)
    found = consensus_circle(np.stack([px, py]).astype(np.float32), (20, 200), 1.5)
    assert found is not None
    # Strays within the tolerance pull a little: half of it is far more than they can.
    assert (found.x, found.y, found.radius) == pytest.approx((x, y, radius), abs=0.75)


def test_points_on_a_line_give_no_circle() -> None:
    x = np.arange(50, dtype=np.float32)
    assert consensus_circle(np.stack([x, 2 * x]), (10, 100), 1.0) is None


@pytest.mark.parametrize("arc", [2 * np.pi, np.pi, np.pi / 3])
def test_offsets_give_the_shift_though_a_third_of_them_is_wrong(arc: float) -> None:
    rng = np.random.default_rng(1)
    angle = rng.uniform(0, arc, 120)
    cosine, sine = np.cos(angle), np.sin(angle)
    used = np.ones(120, np.bool_)
    offset = 2.0 * cosine - 1.5 * sine + 3.0 + rng.normal(0, 0.05, 120)
    offset[::3] = rng.uniform(-8, 8, 40)
    fitted = fit_offsets(bearings(angle), offset.astype(np.float32), used, 0.01, 3.0)
    assert fitted is not None
    # A short arc tells the centre from the radius less well: by about the square of what it lacks.
    tolerance = 0.05 * (2 * np.pi / arc) ** 2
    assert tuple(fitted.by) == pytest.approx((2.0, -1.5, 3.0), abs=tolerance)
    assert (fitted.weight[::3] < 0.5).mean() > 0.8
