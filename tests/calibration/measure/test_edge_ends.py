"""Points near a corner are put back on the edge that ends there."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from endocal.calibration.measure.edge_ends import MOST_OFF, drawn_off, on_their_edges
from endocal.calibration.measure.profiles import Measured, measure, smoothed

# No distortion: what is straight in the picture are lines.
FLAT = np.array([0.0, 100.0, 100.0])
FINE = 8
BLUR, SMOOTHED = 1.0, 1.6
TOP = 60.0
# What sampling between pixels and differences over two px add to a width, px^2.
SAMPLED = 0.5


@pytest.mark.parametrize("slant", [-2.0, -1.0, -0.3, 0.3, 1.0])
def test_a_blurred_wedge_is_steepest_where_it_is_said(slant: float) -> None:
    """Against a drawing: a wedge below y = 0, blurred by 16 px."""
    size, wide = 200, 16.0
    y, x = np.mgrid[-size : size + 1, -size : size + 1].astype(float)
    # A pixel on the edge is half covered.
    drawn = np.clip(0.5 - y, 0, 1) * np.clip(0.5 + (x - slant * y) / np.hypot(1, slant), 0, 1)
    slopes = np.abs(np.gradient(cv2.GaussianBlur(drawn, (0, 0), wide), axis=0))
    at = np.arange(-0.5, 4.0, 0.5)
    rows = slice(size - round(1.6 * wide), size + round(1.6 * wide) + 1)
    steepest = slopes[rows, size + np.rint(at * wide).astype(int)].argmax(axis=0) - 1.6 * wide
    told = drawn_off(at, slant)
    near = np.abs(told) < 1.5
    assert near.sum() >= 6
    assert wide * told[near] == pytest.approx(steepest[near], abs=1.2)


def bars(cotangent: float) -> Measured:
    """Dark slanted bars that end at y = TOP, measured: their six sides, and the row of their ends."""
    size = 200
    y, x = (np.mgrid[: size * FINE, : size * FINE] + 0.5) / FINE - 0.5
    across = x - cotangent * (y - TOP)
    dark = (y > TOP) & (np.abs((across - 20) % 40 - 20) < 10) & (across > 20) & (across < 140)
    clean = cv2.GaussianBlur(np.where(dark, 30.0, 180.0), (0, 0), BLUR * FINE)
    picture = clean.reshape(size, FINE, size, FINE).mean(axis=(1, 3)).astype(np.float32)
    t = np.arange(4.0, 100.0)
    sides = [
        np.stack([left + cotangent * t, TOP + t], axis=1)
        for left in (30.0, 50.0, 70.0, 90.0, 110.0, 130.0)
    ]
    ends = np.concatenate([np.arange(a, a + 20.0) for a in (30.0, 70.0, 110.0)])
    lines = [*sides, np.stack([ends, np.full(len(ends), TOP)], axis=1)]
    lines = [p[(p > 8).all(axis=1) & (p < size - 8).all(axis=1)] for p in lines]
    labels = np.repeat(np.arange(7), [len(p) for p in lines])
    return measure(smoothed(picture, SMOOTHED), np.concatenate(lines), labels, FLAT, follow=True)


@pytest.mark.parametrize("cotangent", [-1.2, -0.5, 0.5, 1.2])
def test_the_ends_of_slanted_bars_are_put_back_in_line(cotangent: float) -> None:
    measured = bars(cotangent)
    widths = np.full(7, np.sqrt(BLUR**2 + SMOOTHED**2 + SAMPLED))
    put = on_their_edges(measured, widths, FLAT)
    before = measured.points[measured.labels == 6][:, 1] - TOP
    after = put.points[put.labels == 6][:, 1] - TOP
    assert before.std() > 0.2, "the corners must draw the ends off for this to tell"
    assert after.std() < 0.07 * before.std()
    assert np.abs(after).max() < 0.4 * np.abs(before).max()
    assert len(after) > 0.6 * len(before)


def test_ends_at_right_angles_stay() -> None:
    measured = bars(0.0)
    put = on_their_edges(measured, np.full(7, 2.0), FLAT)
    assert len(put.points) == len(measured.points)
    assert np.abs(put.points - measured.points).max() < 0.02


def test_a_line_that_goes_on_to_both_sides_draws_no_end_off() -> None:
    """There the edge meets another one, and none of the four corners is a bar's."""
    measured = bars(0.5)
    # Of what lies beyond half as much is seen.
    side = measured.take((measured.labels < 6) & (np.arange(len(measured.labels)) % 2 == 0))
    corner = np.array([30.0, 50.0, 70.0, 90.0, 110.0, 130.0])[side.labels]
    beyond = replace(
        side, points=2 * np.stack([corner, np.full_like(corner, TOP)], axis=1) - side.points
    )
    both = Measured.joined([measured, beyond], np.append(measured.labels, beyond.labels))
    order = np.lexsort((both.points[:, 1] * (both.labels < 6), both.labels))
    both = both.in_order(order, both.labels[order])
    put = on_their_edges(both, np.full(7, 2.0), FLAT)
    ends = both.points[both.labels == 6]
    np.testing.assert_array_equal(put.points[put.labels == 6], ends)


def test_what_is_drawn_off_far_is_left_out() -> None:
    measured = bars(1.2)
    put = on_their_edges(measured, np.full(7, 2.0), FLAT)
    moved = [np.linalg.norm(measured.points - p, axis=1).min() for p in put.points]
    assert len(put.points) < len(measured.points)
    assert max(moved) < MOST_OFF


def test_nothing_measured_is_nothing_to_move() -> None:
    assert len(on_their_edges(Measured.none(), np.empty(0), FLAT).points) == 0
