"""Lines are measured on a picture smoothed as their own blur, length and neighbours want it."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from scipy.special import ndtr

from endocal.calibration.measure.light import Light
from endocal.calibration.measure.matched import (
    SCALES,
    blurs,
    measure_matched,
    rooms,
    usual_lengths,
)
from endocal.calibration.measure.profiles import Measured, measure, smoothed

# No distortion: what is straight in the picture are lines.
FLAT = np.array([0.0, 150.0, 150.0])
SIZE = 300
SLANT = 0.1


def picture(at: list[float], blur: float, noise: float = 0.0) -> np.ndarray:
    """Edges across rows at x = ``at`` + SLANT y, rising and falling by turns, as grey levels."""
    y, x = np.mgrid[:SIZE, :SIZE].astype(float)
    width = blur * np.hypot(1, SLANT)
    steps = [(-1) ** i * ndtr((x - a - SLANT * y) / width) for i, a in enumerate(at)]
    clean = 40 + 100 * np.sum(steps, axis=0)
    return (clean + np.random.default_rng(5).normal(0, noise, clean.shape)).astype(np.float32)


def lines(at: list[float], gaps: bool = False) -> Measured:
    """Points of these edges, one a px; with ``gaps``, dashes of 12 px with as much between them."""
    t = np.arange(12.0, SIZE - 12.0)
    t = t[t % 24 < 12] if gaps else t
    points = np.concatenate([np.stack([a + SLANT * t, t], axis=1) for a in at])
    labels = np.repeat(np.arange(len(at)), len(t))
    sides = np.where(labels % 2 == 0, -1.0, 1.0)  # +1: bright to the left of the way down
    levels = np.tile([40.0, 140.0, 140.0], (len(points), 1))
    return Measured(points, labels, sides, levels, np.ones(len(points)))


def off(measured: Measured, at: list[float]) -> np.ndarray:
    """How far points lie from the edges whose labels they carry, px."""
    x, y = measured.points.T
    return (x - np.array(at)[measured.labels] - SLANT * y) / np.hypot(1, SLANT)


@pytest.mark.parametrize("blur", [0.6, 1.0, 1.5, 2.1])
def test_the_blur_of_an_edge_is_told_through_noise_and_smoothing(blur: float) -> None:
    grey = picture([100.0, 180.0], blur, noise=4.0)
    # A pixel of this picture is a point: nothing but the blur widens its edges.
    assert blurs(smoothed(grey), lines([100.0, 180.0]), FLAT) == pytest.approx(blur, rel=0.08)


def test_soft_edges_scatter_much_less_than_with_little_smoothing() -> None:
    at = [100.0, 180.0]
    grey, known = picture(at, 2.0, noise=4.0), lines(at)
    little = measure(smoothed(grey), known.points, known.labels, FLAT, follow=True)
    matched = measure_matched(grey, smoothed(grey), known, FLAT)
    # Smoothing along the line tells nothing new: what counts are means over stretches of it.
    stretches = [off(m, at).reshape(-1, 23).mean(axis=1).std() for m in (matched, little)]
    assert stretches[0] < 0.6 * stretches[1]
    assert np.abs(off(matched, at).mean()) < 0.02


def test_edges_of_forty_px_are_long_enough_for_the_smoothing_that_their_blur_wants() -> None:
    at = [100.0, 180.0]
    grey, known = picture(at, 2.0, noise=4.0), lines(at)
    dashes = known.take(known.points[:, 1] % 60 < 40)
    whole, parts = (
        off(measure_matched(grey, smoothed(grey), m, FLAT), at).std() for m in (known, dashes)
    )
    assert parts < 1.2 * whole


def test_an_edge_nearby_on_one_side_moves_a_soft_one_little() -> None:
    at = [100.0, 107.0]
    grey, known = picture(at, 1.4), lines(at)
    matched = measure_matched(grey, smoothed(grey), known, FLAT)
    wide = measure(smoothed(grey, SCALES[-1]), known.points, known.labels, FLAT, follow=True)
    assert rooms(known, FLAT) == pytest.approx(7 / np.hypot(1, SLANT), abs=0.2)
    assert np.abs(off(matched, at)).max() < 0.05 < np.abs(off(wide, at)).mean()


def test_a_line_alone_has_room() -> None:
    assert np.isinf(rooms(lines([100.0, 180.0]), FLAT)).all()


def test_lengths_are_those_of_the_dashes_that_make_up_a_line() -> None:
    assert usual_lengths(lines([100.0])) == pytest.approx(275 * np.hypot(1, SLANT), abs=0.1)
    assert usual_lengths(lines([100.0], gaps=True)) == pytest.approx(11 * np.hypot(1, SLANT))


def test_lines_of_different_smoothing_come_in_the_order_of_their_labels() -> None:
    at = [60.0, 130.0, 200.0]
    y, x = np.mgrid[:SIZE, :SIZE].astype(float)
    widths = 0.5, 2.2, 0.5
    grey = 40 + 100 * sum(
        (-1) ** i * ndtr((x - a - SLANT * y) / w)
        for i, (a, w) in enumerate(zip(at, widths, strict=True))
    )
    known = lines(at)
    grey = grey.astype(np.float32)
    matched = measure_matched(grey, smoothed(grey), known, FLAT)
    assert (np.diff(matched.labels) >= 0).all()
    assert np.unique(matched.labels).tolist() == [0, 1, 2]
    assert np.abs(off(matched, at)).max() < 0.03
    # The edge of falling grey levels lies between the two rising ones.
    assert [np.sign(matched.sides[matched.labels == i].sum()) for i in range(3)] in (
        [1, -1, 1],
        [-1, 1, -1],
    )


def test_information_is_the_inverse_of_the_variance_of_points() -> None:
    """Edges of all contrasts and blurs, measured with different smoothing, share one factor."""
    at = [50.0, 130.0, 210.0]
    y, x = np.mgrid[:SIZE, :SIZE].astype(float)
    clean = 20 + np.zeros_like(x)
    for a, blur, height in zip(at, (0.6, 2.0, 1.0), (30, 60, 90), strict=True):
        clean += height * ndtr((x - a - SLANT * y) / blur / np.hypot(1, SLANT))
    known = lines(at)
    told = []
    for seed in range(12):
        noise = np.random.default_rng(seed).normal(0, 1.5, clean.shape)
        grey = (clean + noise).astype(np.float32)
        measured = measure_matched(grey, smoothed(grey), known, FLAT)
        # Neighbours share noise, the more the wider the smoothing: what counts are means over stretches.
        stretches = [
            off(measured, at)[measured.labels == i][:260].reshape(-1, 26) for i in range(3)
        ]
        information = [measured.information[measured.labels == i].mean() for i in range(3)]
        told.append((np.mean([s.mean(axis=1) ** 2 for s in stretches], axis=1), information))
    variance, information = np.mean(told, axis=0)
    share = variance * information
    assert share / share.mean() == pytest.approx(1, abs=0.35)
    assert information.max() > 3 * information.min()


def test_light_that_falls_off_draws_nothing_off_its_edge() -> None:
    at = [100.0, 180.0]
    falling = 1 - 0.5 * np.arange(SIZE) / SIZE
    known = lines(at)
    # Light falls on the sheet before the lens blurs what is seen.
    sharp = picture(at, 0.5) * falling
    grey = cv2.GaussianBlur(sharp, (0, 0), np.sqrt(2.0**2 - 0.5**2)).astype(np.float32)
    # Levels are read 4 px beside an edge; the first is bright to its right, the second to its left.
    beside = known.points[:, :1] + 4 * known.sides[:, None] * [1.0, -1.0, 0.0]
    lit = replace(known, levels=known.levels * (1 - 0.5 * beside / SIZE))
    drawn, back = (
        np.abs(np.bincount(m.labels, off(m, at)) / np.bincount(m.labels))
        for m in (
            measure_matched(grey, smoothed(grey), known, FLAT, light)
            for light in (None, Light.of(lit, FLAT))
        )
    )
    assert np.all(drawn > 0.015)
    assert np.all(back < 0.2 * drawn)
