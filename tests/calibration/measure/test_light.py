"""Light that falls off, and what it draws from the edges."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter
from scipy.special import ndtr

from endocal.calibration.image.picture import Grey
from endocal.calibration.measure.light import (
    MOST_OFF,
    Light,
    fitted_drawn,
    out_of_the_light,
    steepest_drawn,
)
from endocal.calibration.measure.profiles import SMOOTHING, Measured, measure, smoothed

SIZE = 260
FLAT = np.array([-1e-9, 129.5, 129.5])
# Edges lie at these x, px, and run askew; after each BAND px the other side is bright, as on a chessboard.
AT, SLANT, BAND, BESIDE = (50.0, 90.0, 130.0, 170.0, 210.0), 0.03, 52, 10
# They are so sharp, px, where the light falls on them.
SHARP = 0.45


def light(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """It falls to a half from the left, where it is most, to the right."""
    return 1 - 0.5 * ((x + 10) ** 2 + (y - 120) ** 2) / 270**2


def picture(blur: float, gamma: float = 1.0) -> Grey:
    """Light on a board, then blur, then gamma."""
    y, x = np.mgrid[:SIZE, :SIZE].astype(float)
    stripes = sum(
        (-1) ** i * ndtr((x - at - SLANT * y) / SHARP / np.hypot(1, SLANT))
        for i, at in enumerate(AT)
    )
    board = np.where(y // BAND % 2 == 0, stripes, 1 - stripes)
    lit = light(x, y) * (30 + 200 * board) / 230
    soft = gaussian_filter(lit, np.sqrt(blur**2 - SHARP**2), mode="nearest")
    return np.asarray(230 * soft ** (1 / gamma), np.float32)


def seen(blur: float, steps: bool = False, gamma: float = 1.0) -> Measured:
    """The edges of the picture, measured where they are."""
    y = np.arange(12.0, SIZE - 12)
    points = np.concatenate([np.stack([at + SLANT * y, y], axis=1) for at in AT])
    labels = np.repeat(np.arange(len(AT)), len(y))
    m = measure(smoothed(picture(blur, gamma)), points, labels, FLAT, True, steps)
    return m.take(np.abs(m.points[:, 1] % BAND - BAND / 2) < BAND / 2 - BESIDE)


def off(m: Measured) -> np.ndarray:
    """How far to the right of its edge each point is, px."""
    return (m.points[:, 0] - np.array(AT)[m.labels] - SLANT * m.points[:, 1]) / np.hypot(1, SLANT)


def mended_by(
    light: Light, lines: Measured, blur: float, steps: bool = False, gamma: float | None = None
) -> Measured:
    blurs = np.full(len(AT), blur)
    gamma = light.gamma if gamma is None else gamma
    drawn = fitted_drawn(blurs) if steps else steepest_drawn(blurs, SMOOTHING, gamma)
    return out_of_the_light(lines, drawn, blurs, SMOOTHING, FLAT, light)


@pytest.mark.parametrize("blur", [0.8, 1.4, 2.0])
@pytest.mark.parametrize("steps", [False, True], ids=["steepest", "fitted"])
def test_what_light_draws_is_taken_off(blur: float, steps: bool) -> None:
    lines = seen(blur, steps)
    mended = mended_by(Light.of(lines, FLAT), lines, blur, steps)
    # Where the profiles lie between the pixels moves points by some thousandths of a px to and fro.
    before, after = (np.bincount(m.labels, off(m)) for m in (lines, mended))
    # To the left, where the light is, whichever side of the edge is bright.
    assert np.all(before < 0)
    assert np.all(np.abs(after) < 0.25 * np.abs(before).max())


@pytest.mark.parametrize("blur", [1.2, 1.6])
def test_blur_comes_before_a_cameras_gamma(blur: float) -> None:
    """Edges of both kinds, by turns: what gamma makes bright areas grow by cancels in their mean."""

    def mean_off(m: Measured) -> float:
        rows = [(m.sides == side) & (m.labels == line) for side in (-1, 1) for line in (1, 2, 3)]
        return float(np.mean([off(m)[row].mean() for row in rows]))

    lines = seen(blur, gamma=2.2)
    light = Light.of(lines, FLAT)
    assert light.gamma == pytest.approx(2.2, rel=0.15)
    told, blind = (mean_off(mended_by(light, lines, blur, gamma=g)) for g in (None, 1.0))
    # Where profiles lie between the pixels moves points by a thousandth of a px, without gamma, too.
    plain = seen(blur)
    least = mean_off(mended_by(Light.of(plain, FLAT), plain, blur))
    assert abs(told - least) < 0.3 * abs(blind - least)


def test_light_that_falls_faster_than_a_parabola_is_no_gamma() -> None:
    """Cosines to the fourth, of an angle of 40 degrees at the farthest point."""
    lines = seen(1.0)
    across = np.gradient(lines.points[:, 1]) * lines.sides

    def angle(way: float) -> np.ndarray:
        x, y = (lines.points + np.stack([way * across, 0 * across], axis=1)).T
        return np.deg2rad(40) * np.hypot(x + 10, y - 120) / 270

    dark, bright = (np.cos(angle(way)) ** 4 for way in (4, -4))
    levels = np.stack([30 * dark, 230 * bright, 230 * bright], axis=1)
    found = Light.of(replace(lines, levels=levels), FLAT)
    assert found.gamma == 1.0
    np.testing.assert_allclose(
        found.bright.level(lines.points), 230 * np.cos(angle(0)) ** 4, rtol=0.02
    )


def test_the_change_of_light_is_told_by_the_bright_sides() -> None:
    lines = seen(1.0)
    x, y = lines.points.T
    slopes = np.stack([-(x + 10), -(y - 120)], axis=1) / 270**2
    change = Light.of(lines, FLAT).change(lines.points)
    np.testing.assert_allclose(change, slopes / light(x, y)[:, None], atol=3e-4)


@pytest.mark.parametrize("gamma", [1.0, 1.7, 2.4])
def test_light_is_told_through_any_gamma(gamma: float) -> None:
    """Where it falls by half, and a camera shows a power of that, which is no parabola."""
    lines = seen(1.0, gamma=gamma)
    found = Light.of(lines, FLAT)
    x, y = lines.points.T
    slopes = np.stack([-(x + 10), -(y - 120)], axis=1) / 270**2
    change = slopes / light(x, y)[:, None] / gamma
    np.testing.assert_allclose(found.change(lines.points), change, atol=3e-4 / gamma)
    np.testing.assert_allclose(
        found.bright.level(lines.points), 230 * light(x, y) ** (1 / gamma), rtol=0.02
    )


@pytest.mark.parametrize("gamma", [0.8, 1.0, 2.0])
def test_a_veil_over_both_sides_is_no_light(gamma: float) -> None:
    """Stray light lies over black and white alike: what falls off is by how much they differ."""
    x, y = seen(1.0).points.T
    slopes = np.stack([-(x + 10), -(y - 120)], axis=1) / 270**2
    change = slopes / light(x, y)[:, None] / gamma
    lines = seen(1.0, gamma=gamma)
    veiled = replace(lines, levels=lines.levels + 100.0)
    found = Light.of(veiled, FLAT).change(lines.points)
    # The parabola's power is told worse through it: a tenth of what the veil hides of the change at most.
    assert np.abs(found - change).max() < 0.1 * np.abs(change).max()
    alone = mended_by(Light.of(lines, FLAT), lines, 1.0, gamma=1.0)
    mended = mended_by(Light.of(veiled, FLAT), veiled, 1.0, gamma=1.0)
    np.testing.assert_allclose(mended.points, alone.points, atol=0.002)
    np.testing.assert_allclose(mended.levels - 100.0, alone.levels, atol=3.0)


@pytest.mark.parametrize("power", [-0.5, -1.0, -2.0])
def test_a_lamps_light_is_told(power: float) -> None:
    """It falls by the square of the way, which no parabola follows: one over it does, or a power of that."""
    lines = seen(1.0)
    x, y = lines.points.T
    parabola = 1 + ((x + 10) ** 2 + (y - 120) ** 2) / 150**2
    slopes = np.stack([x + 10, y - 120], axis=1) * 2 / 150**2
    across = np.gradient(lines.points[:, 1]) * lines.sides
    dark, bright = (1 + ((x + way * across + 10) ** 2 + (y - 120) ** 2) / 150**2 for way in (4, -4))
    levels = np.stack([30 * dark**power, 230 * bright**power, 230 * bright**power], axis=1)
    found = Light.of(replace(lines, levels=levels), FLAT).change(lines.points)
    change = power * slopes / parabola[:, None]
    assert np.abs(found - change).max() < 0.02 * np.abs(change).max()


@pytest.mark.parametrize(("blur", "gamma"), [(0.6, 2.0), (2.0, 1.0)])
def test_levels_are_those_of_even_light(blur: float, gamma: float) -> None:
    """Read beside an edge they say where the light is, which draws edges of both kinds one way."""
    lines = seen(blur, gamma=gamma)
    mended = mended_by(Light.of(lines, FLAT), lines, blur)
    toward = np.sign(np.gradient(lines.points[:, 1])) * lines.sides  # the light is where x is less
    for before, after in zip(lines.levels.T[:2], mended.levels.T[:2], strict=True):
        lit, unlit = toward > 0, toward < 0
        gap_before, gap_after = (v[lit].mean() - v[unlit].mean() for v in (before, after))
        assert np.ptp(after) < 0.1 * np.ptp(before)
        assert abs(gap_after) < 0.25 * abs(gap_before)
    # 4 px beside a soft edge white is not quite what it is farther off.
    white = 230 - 200 * ndtr(-4 / np.sqrt(blur**2 + SMOOTHING**2))
    np.testing.assert_allclose(
        mended.levels[:, 2], white * light(*lines.points.T) ** (1 / gamma), rtol=0.02
    )


def test_highlights_tell_nothing_of_it() -> None:
    lines = seen(1.0)
    near = np.linalg.norm(lines.points - [180, 60], axis=1) < 40
    lit = replace(lines, levels=lines.levels + np.where(near, 60.0, 0.0)[:, None])
    alone, with_it = (Light.of(m, FLAT).change(lines.points) for m in (lines, lit))
    # A tenth of the points, far brighter: counted in full they would change it by half.
    assert np.abs(with_it - alone).max() < 0.05 * np.abs(alone).max()


def test_where_hardly_any_light_is_left_it_draws_its_way_and_not_far() -> None:
    lines = seen(1.0)
    x, y = lines.points.T
    lit = np.maximum(1 - 1.3 * ((x + 10) ** 2 + (y - 120) ** 2) / 270**2, 0.02)
    dark = replace(lines, levels=lines.levels * [1, 0, 1] + np.outer(200 * lit, [0, 1, 0]))
    mended = mended_by(Light.of(dark, FLAT), dark, 2.0)
    moved = mended.points[:, 0] - x
    # All to the right, away from the light, by no more than is believed of it.
    assert moved.min() > 0
    assert moved.max() < 1.01 * MOST_OFF


def test_even_light_moves_nothing() -> None:
    lines = seen(1.0)
    even = replace(lines, levels=np.tile([30.0, 230.0, 230.0], (len(lines.points), 1)))
    mended = mended_by(Light.of(even, FLAT), even, 1.0)
    np.testing.assert_allclose(mended.points, lines.points, atol=1e-9)
    np.testing.assert_allclose(mended.levels, even.levels)
