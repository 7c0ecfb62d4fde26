"""Votes that count once for a range of models: they fall into one cell under each of them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from endocal.calibration.hough.hewg import magnification
from endocal.calibration.hough.settled import settled
from endocal.calibration.hough.votes import FOLDING, Around, Room, Voters

SIZE = (720, 540)


def voters_at_random(seed: int, count: int = 300) -> Voters:
    rng = np.random.default_rng(seed)
    angles = rng.uniform(0, 2 * np.pi, count)
    gradients = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return Voters.of(rng.uniform((0, 0), SIZE, (count, 2)), gradients, SIZE[1])


def grid(strength: float, width: float, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Axes about a model of lam r^2 = ``strength`` at 450 px, ``width`` times a search's region wide."""
    rng = np.random.default_rng(seed)
    lams = (strength + width * rng.uniform(-0.5, 0.5, 4)) / 450**2
    xs, ys = (rng.uniform(0.45, 0.55) * s + width * 0.05 * s * rng.uniform(-1, 1, 3) for s in SIZE)
    return lams, xs, ys


def magnifications_of(
    voters: Voters, lams: np.ndarray, xs: np.ndarray, ys: np.ndarray
) -> np.ndarray:
    rows = [Around.of(voters, np.full(len(ys), x), ys).square[:, 0] for x in xs]
    return np.stack([magnification(row, lams) for row in rows])


def check_they_have_one_cell(
    voters: Voters, lams: np.ndarray, xs: np.ndarray, ys: np.ndarray, magnifications: np.ndarray
) -> np.ndarray:
    """Hold all models of a grid to the cells of the settled votes, and return which these are, (n,)."""
    sure, cells = settled(voters, lams, xs, ys, magnifications)
    assert len(cells) == np.count_nonzero(sure)
    room = Room(len(lams) * len(ys) * len(voters))
    for x, m in zip(xs, magnifications, strict=True):
        with np.errstate(all="ignore"):
            found = Around.of(voters, np.full(len(ys), x), ys).cells(lams, m, room)
        assert (found[..., sure] == cells).all()
    return sure


@given(st.floats(-0.95, 0.4), st.floats(-6, 0), st.integers(0, 2**31))
def test_they_have_one_cell_under_every_model(strength: float, width: float, seed: int) -> None:
    voters = voters_at_random(seed)
    lams, xs, ys = grid(strength, 10**width, seed)
    magnifications = magnifications_of(voters, lams, xs, ys)
    # By whatever law models magnify.
    noise = np.random.default_rng(seed).uniform(-0.5, 0.5, magnifications.shape)
    magnifications = magnifications * np.exp(10**width * noise)
    check_they_have_one_cell(voters, lams, xs, ys, magnifications)


@pytest.mark.parametrize("strength", [-0.8, 0.3])
def test_they_have_one_cell_about_a_given_centre_whatever_lambda(strength: float) -> None:
    """No slack for another centre hides what votes move by beyond the first order."""
    # Of lines that nearly meet the centre, whose angles and offsets move least.
    rng = np.random.default_rng(3)
    angle = rng.uniform(0, 2 * np.pi, 20_000)
    normal = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    along = np.stack([-normal[:, 1], normal[:, 0]], axis=1) * rng.uniform(100, 450, (20_000, 1))
    points = np.array([360.0, 270.0]) + along + normal * rng.uniform(-6, 6, (20_000, 1))
    voters = Voters.of(points, normal, SIZE[1])
    lams = (strength + 0.1 * np.array([-1.0, 1.0])) / 450**2
    xs, ys = np.array([360.0]), np.array([270.0])
    magnifications = np.ones((1, 1, 2))
    sure = check_they_have_one_cell(voters, lams, xs, ys, magnifications)
    assert sure.mean() > 0.1


def test_a_vote_that_some_models_fold_is_not_settled() -> None:
    """Edges that point to the centre hardly move, but those past a fold vote each for itself."""
    angle = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    way = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    # By whole and half px inside of where models about the middle would fold them.
    reach = np.sqrt(FOLDING) * 200 - np.repeat([0.1, 40.0], 200)
    points = np.array([360.0, 270.0]) + reach[:, None] * way
    voters = Voters.of(points, np.stack([-way[:, 1], way[:, 0]], axis=1), SIZE[1])
    lams, xs, ys = np.array([-1 / 200**2]), 360 + np.array([-0.2, 0.2]), np.array([270.0])
    sure = check_they_have_one_cell(voters, lams, xs, ys, magnifications_of(voters, lams, xs, ys))
    assert sure[200:].mean() > 0.3


@pytest.mark.parametrize(("width", "share"), [(1e-2, 0.3), (1e-3, 0.85), (1e-4, 0.97), (0.0, 0.98)])
def test_the_narrower_the_range_the_more_votes_settle(width: float, share: float) -> None:
    voters = voters_at_random(0, 2000)
    lams, xs, ys = grid(-0.4, width, 1)
    sure, _ = settled(voters, lams, xs, ys, magnifications_of(voters, lams, xs, ys))
    assert sure.mean() > share


def test_no_vote_past_a_fold_is_settled() -> None:
    voters = voters_at_random(0)
    lams, xs, ys = np.array([-1 / 100**2]), np.array([360.0]), np.array([270.0])
    sure, _ = settled(voters, lams, xs, ys, magnifications_of(voters, lams, xs, ys))
    squares = (voters.x - 360) ** 2 + (voters.y - 270) ** 2
    assert sure.any()
    assert not sure[squares >= 0.98 * 100**2].any()
