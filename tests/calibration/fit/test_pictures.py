"""Which of several pictures do not go with the others, by what each tells alone."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from endocal.calibration.calibrate import calibrate_jointly
from endocal.calibration.fit.measured import Refined
from endocal.calibration.fit.pictures import distances, strangers
from endocal.calibration.fit.plumb_line import Prior, fit_model
from endocal.calibration.measure.profiles import Measured
from endocal.files import read_image
from endocal.synth.board import render_board

from ..scenes import TRUTH, board, line_points

PRIOR = Prior((319.5, 239.5), (32.0, 24.0))


def apart(*places: float) -> np.ndarray:
    """Distances of pictures that lie at these places of a line."""
    at = np.array(places)
    return np.abs(at[:, None] - at)


@pytest.mark.parametrize(
    ("places", "strange"),
    [
        ((0, 1, 2, 3), []),
        ((0,), []),
        ((0, 1, 90, 2), [2]),
        ((0, 90, 1, 200, 2), [3, 1]),
        # One that differs from a single other, as far as that is known, is none.
        ((0, 5, 10), []),
    ],
)
def test_who_lies_far_from_most_is_a_stranger(
    places: tuple[float, ...], strange: list[int]
) -> None:
    assert strangers(apart(*places), most=8.0) == strange


@pytest.mark.parametrize("places", [(0, 9), (0, 100, 200)])
def test_where_none_go_together_all_are_strange(places: tuple[float, ...]) -> None:
    assert sorted(strangers(apart(*places), most=8.0)) == list(range(len(places)))


def test_of_two_and_two_no_more_than_two_are_alike() -> None:
    assert len(strangers(apart(0, 1, 90, 91), most=8.0)) == 2


def lines_of_pictures(*noises: float) -> tuple[Refined, np.ndarray]:
    """Lines of one lens in pictures of such noise, px, fitted together, and the picture of each point.

    Pictures of one noise are the same, whatever their order.
    """
    points, labels, pictures = [], [], []
    for i, noise in enumerate(noises):
        exact, line, normals = line_points(TRUTH, count=12, seed=int(1000 * noise))
        off = np.random.default_rng(int(1000 * noise)).normal(0, noise, len(exact))
        points.append(exact + off[:, None] * normals)
        labels.append(line + 12 * i)
        pictures.append(np.full(len(exact), i))
    at, line = np.concatenate(points), np.concatenate(labels)
    one = np.ones(len(at))
    m = Measured(at, line, one, np.outer(one, [20.0, 200.0, 200.0]), one)
    fit = fit_model(at, line, TRUTH, 300.0, PRIOR, 0.5, m.sides)
    view = np.concatenate(pictures)
    return Refined(fit, m, view, frozenset()), view


def distances_of(*noises: float) -> np.ndarray:
    refined, pictures = lines_of_pictures(*noises)
    return distances(refined, pictures, 300.0, PRIOR, 0.0)


def test_how_far_two_pictures_lie_apart_is_told_by_how_sure_both_are() -> None:
    """A noisy picture of the same lens lies some way off, and is known to: whichever picture is first."""
    apart, turned = distances_of(0.03, 0.8), distances_of(0.8, 0.03)
    assert apart[1, 0] == apart[0, 1] < 3
    assert turned[1, 0] == pytest.approx(apart[1, 0], rel=1e-3)


@pytest.mark.parametrize("zoom", [1.01, 1.1])
def test_a_picture_of_another_zoom_setting_is_left_out(zoom: float) -> None:
    """Of a hundredth, too."""
    poses = ((100, 10, 5), (20, 30, 40), (250, 15, 70), (160, 25, 20))
    pictures = [
        render_board(board(lam=-2e-6 / (zoom if i == 2 else 1) ** 2, axis=a, tilt=t, rotation=r))
        for i, (a, t, r) in enumerate(poses)
    ]
    joint = calibrate_jointly(pictures)
    assert joint.left_out == (2,)
    assert joint.calibration.model.lam == pytest.approx(-2e-6, rel=1e-3)


def boards(folder: Path, lens: str) -> list[np.ndarray]:
    return [read_image(path) for path in sorted((folder / "boards" / lens).iterdir())]


@pytest.mark.parametrize("lens", ["endoscope_6080hd", "fisheye1"])
def test_pictures_of_a_real_lens_go_together(lens: str, real_data: Path) -> None:
    """Neither is a division model, and what each picture tells alone differs by far more than noise."""
    joint = calibrate_jointly(boards(real_data, lens))
    assert joint.left_out == ()
    assert [reason for reason in joint.calibration.quality.reasons if "together" in reason] == []


def test_an_enlarged_picture_of_a_real_lens_is_left_out(real_data: Path) -> None:
    pictures = boards(real_data, "endoscope_6080hd")
    height, width = pictures[1].shape[:2]
    larger = cv2.getRotationMatrix2D((width / 2, height / 2), 0, 1.25)
    pictures[1] = cv2.warpAffine(pictures[1], larger, (width, height), flags=cv2.INTER_CUBIC)
    assert calibrate_jointly(pictures).left_out == (1,)
