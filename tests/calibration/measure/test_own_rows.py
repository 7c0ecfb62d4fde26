"""Nearly level edges of one field are measured on the rows that it has."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ndtr

from endocal.calibration.calibrate import calibrate
from endocal.calibration.image.picture import fields
from endocal.calibration.measure.own_rows import UNIT, on_own_rows
from endocal.calibration.measure.profiles import Measured, measure, smoothed
from endocal.synth.board import render_board

from ..scenes import board

# No distortion: what is straight in the picture are lines.
FLAT = np.array([0.0, 200.0, 60.0])
WIDTH, HEIGHT = 400, 120
FIRST = 1  # the odd field
NOISE = 4.0


def field(slope: float, blur: float, noise: float = 0.0, seed: int = 3) -> np.ndarray:
    """The odd rows of an edge along y = 60.3 + slope (x - 200), the others interpolated."""
    y, x = np.mgrid[:HEIGHT, :WIDTH].astype(float)
    away = (y - 60.3 - slope * (x - 200)) / np.hypot(1, slope)
    clean = 40 + 120 * ndtr(away / blur)
    grey = clean + np.random.default_rng(seed).normal(0, noise, clean.shape)
    out = grey.astype(np.float32)
    out[2:-1:2] = (out[1:-2:2] + out[3::2]) / 2
    out[0] = out[1]
    return out


def lines(slope: float) -> Measured:
    """Points on that edge, one a px."""
    x = np.arange(20.0, 380.0)
    points = np.stack([x, 60.3 + slope * (x - 200)], axis=1)
    zero = np.zeros(len(x), np.intp)
    levels = np.tile([40.0, 160.0], (len(x), 1))
    return Measured(points, zero, np.full(len(x), -1.0), levels, np.ones(len(x)))


def off(measured: Measured, slope: float) -> np.ndarray:
    """How far points lie from the edge, px."""
    x, y = measured.points.T
    return np.asarray((y - 60.3 - slope * (x - 200)) / np.hypot(1, slope))


def between_rows(grey: np.ndarray, slope: float) -> Measured:
    """The edge measured on what is interpolated."""
    known = lines(slope)
    return measure(smoothed(grey), known.points, known.labels, FLAT, follow=True)


@pytest.mark.parametrize("slope", [0.05, 0.08, -0.15])
@pytest.mark.parametrize("blur", [0.35, 0.5])
def test_a_sharp_edge_waves_between_rows_and_not_on_them(slope: float, blur: float) -> None:
    grey = field(slope, blur)
    waving = between_rows(grey, slope)
    own = on_own_rows(grey, FIRST, waving, FLAT)
    assert np.quantile(np.abs(off(waving, slope)), 0.9) > 0.15
    assert np.quantile(np.abs(off(own, slope)), 0.9) < 0.04
    assert len(own.points) > 0.5 * len(waving.points)


def test_a_level_edge_between_two_rows_tells_hardly_anything() -> None:
    """It may lie anywhere there; one that a row cuts through is known."""
    between, through = (
        on_own_rows(grey, FIRST, between_rows(grey, 0.0), FLAT).information.mean()
        for grey in (field(0.0, 0.35), field_on_a_row())
    )
    assert between < 0.2 * through


def field_on_a_row() -> np.ndarray:
    """A level edge that a row of the field cuts through."""
    y = np.mgrid[:HEIGHT, :WIDTH][0].astype(float)
    out = (40 + 120 * ndtr((y - 61.0) / 0.35)).astype(np.float32)
    out[2:-1:2] = (out[1:-2:2] + out[3::2]) / 2
    return out


def test_information_is_what_noise_does() -> None:
    slope, blur = 0.12, 0.5
    means, told = [], []
    for seed in range(40):
        grey = field(slope, blur, NOISE, seed)
        own = on_own_rows(grey, FIRST, between_rows(grey, slope), FLAT)
        means.append(np.average(off(own, slope), weights=own.information))
        told.append(own.information.sum() * UNIT)
    assert np.std(means) == pytest.approx(NOISE / np.sqrt(np.mean(told)), rel=0.35)


@pytest.mark.parametrize(("slope", "blur"), [(0.1, 1.3), (0.05, 1.06), (0.02, 1.06)])
def test_soft_edges_stay_as_they_are(slope: float, blur: float) -> None:
    soft = between_rows(field(slope, blur), slope)
    assert on_own_rows(field(slope, blur), FIRST, soft, FLAT) is soft


def test_steep_edges_stay_as_they_are() -> None:
    steep = lines(0.1)
    turned = Measured(
        steep.points[:, ::-1].copy(), steep.labels, steep.sides, steep.levels, steep.information
    )
    assert on_own_rows(field(0.1, 0.4), FIRST, turned, FLAT) is turned
    assert len(on_own_rows(field(0.1, 0.4), FIRST, Measured.none(), FLAT).points) == 0


def test_a_sharp_interlaced_board_that_lies_level_is_calibrated_as_well() -> None:
    scene = board(comb=(2.0, 0.3), blur=0.3, noise=0.0, rotation=2.0, tilt=8.0)
    picture = render_board(scene)
    assert len(fields(picture.astype(np.float32))) == 2
    found = calibrate(picture).model
    assert np.hypot(*np.subtract(found.center, scene.division.center)) < 0.1
    assert found.lam == pytest.approx(scene.division.lam, rel=2e-3)
