"""The fit by straightness in the corrected picture."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

from endocal.benchmarks.corner_score import straightness
from endocal.calibration.board.lifted import Corners
from endocal.calibration.fit.corner_fit import fit_corners, fit_corners_from_one, tell_apart
from endocal.calibration.fit.plumb_line import Prior
from endocal.calibration.fit.uncertainty import covariance
from endocal.calibration.straightness import LEAST_DENOMINATOR, root_mean_square
from endocal.model import DivisionModel
from endocal.synth.board import BoardScene, true_corners
from endocal.synth.fisheye import Fisheye
from endocal.synth.pattern import Pattern, Pose

SIZE, CENTER = (748, 480), (380.0, 236.0)
PRIOR = Prior(((SIZE[0] - 1) / 2, (SIZE[1] - 1) / 2), (37.0, 24.0))
FISHEYE = Fisheye("equisolid", 200.0, CENTER, SIZE)
START = np.array([-7e-6, 374.0, 240.0])


def seen(lens: DivisionModel | Fisheye, at: tuple[float, float] = (330.0, 260.0)) -> np.ndarray:
    """The corners (rows, cols, 2) px of a near, tilted board through a lens."""
    pose = Pose(at, 40.0, tilt=35, tilt_axis=20, rotation=8, focal=200.0)
    return true_corners(BoardScene(lens, Pattern(cols=10, rows=8), pose))[0]


def at_the_rim() -> np.ndarray:
    """The corners (rows, cols, 2) px of a small, steep board up to 80 degrees off the axis of a lens."""
    pose = Pose((200.0, 300.0), 30.0, tilt=55, tilt_axis=160, rotation=8, focal=170.0)
    lens = Fisheye("equisolid", 170.0, CENTER, SIZE)
    return true_corners(BoardScene(lens, Pattern(cols=8, rows=7), pose))[0]


def board(corners: np.ndarray) -> Corners:
    """The same, in any order."""
    rows, cols = np.indices(corners.shape[:2])
    order = np.random.default_rng(0).permutation(rows.size)
    places = np.stack([rows.ravel(), cols.ravel()], axis=1)
    return Corners(corners.reshape(-1, 2)[order], places[order] - 3)


def model_of(params: np.ndarray) -> DivisionModel:
    lam2 = params[3] if len(params) > 3 else 0.0
    return DivisionModel(params[0], tuple(params[1:3]), SIZE, lam2=lam2)


def test_a_lens_of_the_model_is_found() -> None:
    truth = np.array([-8e-6, *CENTER])
    corners = seen(model_of(truth))
    prior = Prior(CENTER, PRIOR.spread)
    found = fit_corners([board(corners)], START, prior, 0.0)
    assert found is not None
    np.testing.assert_allclose(found[0].params, truth, rtol=1e-5)
    assert found[0].residuals.shape == found[1].shape == (2 * 63,)


@pytest.mark.parametrize("seed", range(6))
def test_noisy_corners_tell_nothing_of_a_lens_that_lines_told(seed: int) -> None:
    """They are straighter under their own fit, as any numbers are, and its centre is pixels off."""
    truth = np.array([-8e-6, *CENTER])
    corners = seen(model_of(truth))
    noisy = [board(corners + np.random.default_rng(seed).normal(0, 0.5, corners.shape))]
    found = fit_corners(noisy, truth, PRIOR, 0.0)
    assert found is not None
    assert not tell_apart(noisy, found, truth)


def test_corners_tell_another_lens_from_the_nearest_that_lines_told() -> None:
    corners = seen(FISHEYE)
    noisy = [board(corners + np.random.default_rng(0).normal(0, 0.05, corners.shape))]
    found = fit_corners(noisy, START, PRIOR, 0.0)
    assert found is not None
    assert tell_apart(noisy, found, found[0].params * [1.02, 1.0, 1.0])


def test_where_corners_may_not_go_their_own_fit_decides() -> None:
    """Under the parameters before, one corner is at the pole, and all else is small beside it."""
    corners = [board(at_the_rim())]
    found = fit_corners(corners, START, PRIOR, 0.0)
    assert found is not None
    reach = float(np.linalg.norm(corners[0].points - found[0].params[1:3], axis=1).max())
    assert tell_apart(corners, found, np.array([-0.9999 / reach**2, *found[0].params[1:3]]))


@pytest.mark.parametrize("second", [False, True], ids=["division", "division2"])
def test_another_lens_is_made_as_straight_as_the_model_can(second: bool) -> None:
    """No simplex from there finds a model that makes the corners straighter, as others score it."""
    corners = seen(FISHEYE)
    reach = float(np.linalg.norm(corners - CENTER, axis=-1).max())
    start = np.append(START, 0.0) if second else START
    found = fit_corners([board(corners)], start, PRIOR, 1.1 * reach)
    assert found is not None
    params, unit = found[0].params, np.array([1e-6, 10, 10, 1e-11])[: len(start)]
    mine = straightness(corners, model_of(params))
    best = minimize(
        lambda x: straightness(corners, model_of(params + unit * x)), 0 * unit, method="Nelder-Mead"
    )
    assert mine < straightness(corners, model_of(start))
    # The belief about the centre weighs as one line of seventeen.
    assert mine < 1.03 * best.fun
    assert mine > 0.1 or second, "the lens must depart from the model for this to tell"
    # What it says of itself is that figure.
    assert np.sqrt(np.mean(found[0].residuals ** 2)) == pytest.approx(mine, rel=1e-6)


@pytest.mark.parametrize("second", [False, True], ids=["division", "division2"])
def test_no_corner_is_sent_to_the_pole(second: bool) -> None:
    """A small board at the rim of a lens that the model cannot follow leads there: the bound holds.

    The centre moves by a good part of the frame on the way, and the two-parameter model is told to be
    monotonic over the middle alone.
    """
    corners = at_the_rim()
    start = np.append(START, 0.0) if second else START
    found = fit_corners([board(corners)], start, PRIOR, 100.0)
    assert found is not None
    model = model_of(found[0].params)
    q = ((corners - found[0].params[1:3]) ** 2).sum(axis=-1)
    assert model.denominator(q).min() == pytest.approx(LEAST_DENOMINATOR, abs=1e-3)
    assert model.valid_radius**2 > q.max()
    assert np.isfinite(straightness(corners, model))


@pytest.mark.parametrize("corners", [at_the_rim(), seen(FISHEYE)], ids=["at the rim", "tilted"])
def test_two_parameters_are_sought_from_one_too(corners: np.ndarray) -> None:
    """Also where the one-parameter fit ends with its farthest corner at the bound."""
    start = np.array([-6e-6, *CENTER])
    fits = (
        fit_corners([board(corners)], start, PRIOR, 0.0),
        fit_corners([board(corners)], np.append(start, -2e-11), PRIOR, 100.0),
        fit_corners_from_one([board(corners)], start, PRIOR, 100.0),
    )
    one, two, by_way_of_one = (root_mean_square(fit[0].residuals) for fit in fits if fit)
    assert by_way_of_one == pytest.approx(two, rel=0.01)
    assert two < 0.1 * one
    too_few = board(seen(FISHEYE)[:2, :3])
    assert fit_corners_from_one([too_few], start, PRIOR, 100.0) is None


def test_two_boards_weigh_alike() -> None:
    rng = np.random.default_rng(4)
    one, two = (
        seen(FISHEYE, at) + rng.normal(0, 0.1, (7, 9, 2)) for at in ((330.0, 260.0), (420.0, 215.0))
    )
    joint = fit_corners([board(one), board(two)], START, PRIOR, 0.0)
    assert joint is not None
    score = [straightness(c, model_of(joint[0].params)) for c in (one, two)]
    assert np.sqrt(np.mean(joint[0].residuals ** 2)) == pytest.approx(np.hypot(*score) / np.sqrt(2))
    assert (np.diag(covariance(*joint)) > 0).all()


def test_a_given_centre_stays() -> None:
    corners = seen(FISHEYE)
    given = Prior((385.0, 240.0), (0.0, 0.0))
    start = np.array([START[0], 385.0, 240.0])
    found = fit_corners([board(corners)], start, given, 0.0)
    assert found is not None
    assert found[0].params[1:].tolist() == [385.0, 240.0]
    assert found[0].free == [0]
    assert found[0].params[0] != START[0]


def test_corners_with_wrong_numbers_tell_nothing() -> None:
    """A lattice that takes one row's corners for another's is no evidence of a lens."""
    corners = seen(FISHEYE)
    mixed = corners.copy()
    mixed[2, 5:], mixed[3, 5:] = corners[3, 5:], corners[2, 5:]
    for grid, usable in ((corners, True), (mixed, False)):
        found = fit_corners([board(grid)], START, PRIOR, 0.0)
        assert (found is not None) == usable


def test_too_few_rows_and_columns_tell_nothing() -> None:
    corners = seen(FISHEYE)[:2, :3]
    assert fit_corners([board(corners)], START, PRIOR, 0.0) is None
    whole, nothing = board(seen(FISHEYE)), Corners(np.empty((0, 2)), np.empty((0, 2), np.intp))
    assert fit_corners([whole, nothing], START, PRIOR, 0.0) is None


@pytest.mark.parametrize("astray", [0.0, 6.0])
def test_a_corner_that_is_anothers_makes_none_be_taken(astray: float) -> None:
    """A fifth of a square off, where others are off by 0.1 px."""
    corners = seen(FISHEYE) + np.random.default_rng(6).normal(0, 0.1, (7, 9, 2))
    corners[3, 4] += (astray, 0.0)
    found = fit_corners([board(corners)], START, PRIOR, 0.0)
    assert (found is None) == (astray > 0)
