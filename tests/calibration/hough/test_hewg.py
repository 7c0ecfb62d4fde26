"""The entropy of the vote map: by the article's equations written down plainly, and on known edges."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from endocal.benchmarks import plain_hewg
from endocal.calibration.hough.hewg import ROUNDED, hewg, magnification
from endocal.calibration.hough.tally import gains_of
from endocal.calibration.hough.votes import ANGLES, SEAMS, Voters, _emptiest
from endocal.calibration.objective import MOST_VOTERS_FOR_START
from endocal.model import DivisionModel

AGAIN = "endocal.calibration.hough.hewg._count_best_again"
SIZE = (720, 540)
TRUTH = DivisionModel(-3e-6, (366.0, 262.0), SIZE)


def edges_on_lines(
    model: DivisionModel, count: int = 14, samples: int = 300
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Distorted points on straight lines, half of them each way: places, gradients (n, 2), labels (n,)."""
    reach = np.linalg.norm(model.undistort(np.array([0.0, 0.0])) - model.center)
    points, gradients, labels = [], [], []
    for i in range(count):
        # In the middle of cells, so that rounding moves no vote.
        phi = np.deg2rad(20.5 if i % 2 else 110.5)
        normal = np.array([np.cos(phi), np.sin(phi)])
        offset = 40.0 * (i // 2 - count // 4) + 1.0
        along = np.linspace(-0.9, 0.9, samples)[:, None] * reach
        line = model.center + offset * normal + along * np.array([-normal[1], normal[0]])
        seen = model.distort(line)
        seen = seen[np.all((seen >= 0) & (seen <= np.array(SIZE) - 1), axis=1)]
        points.append(seen)
        gradients.append(distorted_gradient(model, seen, normal))
        labels.append(np.full(len(seen), i))
    return np.concatenate(points), np.concatenate(gradients), np.concatenate(labels)


def distorted_gradient(model: DivisionModel, points: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """The normal of an undistorted line, seen in the distorted picture: the Jacobian transposed."""
    g = np.einsum("...ji,j->...i", model.jacobian(points), normal)
    return g / np.linalg.norm(g, axis=-1, keepdims=True)


@given(st.integers(0, 2**31), st.floats(-0.9, 0.5))
def test_it_is_the_entropy_of_the_article(seed: int, strength: float) -> None:
    rng = np.random.default_rng(seed)
    points = rng.uniform((0, 0), SIZE, (400, 2))
    angles = rng.uniform(0, 2 * np.pi, 400)
    gradients = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    voters = Voters.of(points, gradients, SIZE[1])
    lams = np.array([strength, strength / 3]) / 500**2
    xs, ys = np.array([340.0, 365.0]), np.array([262.0, 275.0])
    found = hewg(voters, lams, xs, ys)
    plain = plain_hewg.grid(plain_hewg.Votes.of(voters), lams, xs, ys)
    # Rounding to float32 may move a few votes over a cell's border, each by 2 ln 2 / n at most when the
    # cells hold one or two votes.
    assert found == pytest.approx(plain, abs=6 * 2 * np.log(2) / len(points))


def test_the_vote_of_an_edge_point_does_not_depend_on_which_side_is_bright() -> None:
    points, gradients, _ = edges_on_lines(TRUTH)
    turned = gradients * np.random.default_rng(0).choice([-1, 1], len(points))[:, None]
    grid = (np.array([-3e-6, -1e-6]), np.array([366.0]), np.array([262.0]))
    found = [hewg(Voters.of(points, g, SIZE[1]), *grid) for g in (gradients, turned)]
    assert found[0] == pytest.approx(found[1], abs=1e-6)


def test_under_the_true_model_each_line_is_one_cell() -> None:
    points, gradients, labels = edges_on_lines(TRUTH)
    voters = Voters.of(points, gradients, SIZE[1], spread=0)
    found = hewg(voters, np.array([TRUTH.lam]), *(np.array([c]) for c in TRUTH.center))
    p = np.bincount(labels) / len(points)
    # At the magnification there, rounding may split a line that lies on the border of two cells.
    assert found.item() == pytest.approx(-(p * np.log(p)).sum(), abs=1.5 / len(p))


def test_the_true_model_has_the_least_entropy_around() -> None:
    points, gradients, _ = edges_on_lines(TRUTH)
    voters = Voters.of(points, gradients, SIZE[1])
    lams = TRUTH.lam * np.linspace(0.5, 1.5, 11)
    xs, ys = (c + np.linspace(-30, 30, 7) for c in TRUTH.center)
    found = hewg(voters, lams, xs, ys)
    assert np.unravel_index(np.argmin(found), found.shape) == (5, 3, 3)


def test_the_magnification_is_that_of_areas() -> None:
    points = np.random.default_rng(0).uniform((100, 50), (600, 500), (100, 2))
    areas = np.linalg.det(TRUTH.jacobian(points))
    squares = ((points - TRUTH.center) ** 2).sum(axis=1)
    found = magnification(squares, np.array([TRUTH.lam, 0.0]))
    assert found[0] == pytest.approx(np.exp(np.log(areas).mean() / 2))
    assert found[1] == 1


@pytest.mark.parametrize("sign", [-1, 1])
def test_points_past_the_fold_vote_alone(sign: int) -> None:
    angle = np.linspace(0, 2 * np.pi, 100, endpoint=False)
    points = np.stack([360 + 200 * np.cos(angle), 270 + 200 * np.sin(angle)], axis=1)
    gradients = np.tile([1.0, 0.0], (100, 1))
    voters = Voters.of(points, gradients, SIZE[1])
    folded = hewg(voters, np.array([sign / 150**2]), np.array([360.0]), np.array([270.0]))
    assert folded.item() == pytest.approx(np.log(100))


@pytest.mark.parametrize("rows", [0, 1, 3, 16])
def test_the_blocks_of_a_grid_do_not_show(monkeypatch: pytest.MonkeyPatch, rows: int) -> None:
    points, gradients, _ = edges_on_lines(TRUTH)
    voters = Voters.of(points, gradients, SIZE[1])
    grid = (np.linspace(-4e-6, -1e-7, 7), np.array([350.0, 366.0, 367.0]), np.array([262.0]))
    whole = hewg(voters, *grid)
    monkeypatch.setattr("endocal.calibration.hough.hewg.BLOCK", rows * len(points))
    monkeypatch.setattr("endocal.calibration.hough.hewg.SHARED", 2 * len(points))
    assert np.array_equal(hewg(voters, *grid), whole)


@pytest.mark.parametrize("rows", [1, 2, 16])
def test_of_a_grid_only_those_chosen_are_counted(
    monkeypatch: pytest.MonkeyPatch, rows: int
) -> None:
    points, gradients, _ = edges_on_lines(TRUTH)
    voters = Voters.of(points, gradients, SIZE[1])
    grid = (np.linspace(-4e-6, -1e-7, 7), np.array([350.0, 366.0, 367.0]), np.array([262.0, 263.0]))
    chosen = np.random.default_rng(rows).random((7, 3, 2)) < 0.5
    monkeypatch.setattr("endocal.calibration.hough.hewg.BLOCK", rows * len(points))
    monkeypatch.setattr(AGAIN, lambda *grid: None)
    whole = hewg(voters, *grid)
    assert np.array_equal(hewg(voters, *grid, chosen), np.where(chosen, whole, np.inf))


@pytest.mark.parametrize("width", [1.0, 0.05, 0.01, 1e-4, 0.0])
def test_a_grid_has_the_entropies_of_its_models_each_by_itself(
    monkeypatch: pytest.MonkeyPatch, width: float
) -> None:
    # The narrower, the more votes are counted once for all; parted wherever that can be. None is counted
    # again.
    monkeypatch.setattr("endocal.calibration.hough.hewg.MANY_VOTES", 5000)
    monkeypatch.setattr(AGAIN, lambda *grid: None)
    points, gradients, _ = edges_on_lines(TRUTH)
    turned = np.random.default_rng(0).normal(0, 0.02, (len(points), 1))
    gradients = gradients + turned * gradients[:, ::-1] * (1, -1)
    voters = Voters.of(points, gradients, SIZE[1])
    lams = -3e-6 + width * np.linspace(-2.9e-6, 2e-6, 5)
    xs, ys = (c + width * np.linspace(-36, 27, 4) for c in TRUTH.center)
    alone = [
        hewg(voters, lams[i : i + 1], xs[j : j + 1], ys[k : k + 1]).item()
        for i, j, k in np.ndindex(5, 4, 4)
    ]
    assert np.array_equal(hewg(voters, lams, xs, ys).ravel(), alone)


@pytest.mark.parametrize("width", [1.0, 0.05, 1e-3])
def test_rounding_does_not_decide_which_model_is_best(
    monkeypatch: pytest.MonkeyPatch, width: float
) -> None:
    """The best of a grid has the entropy that double precision gives it, and no other has a smaller one."""
    size = (1920, 1080)

    def grids(seed: int) -> tuple[np.ndarray, np.ndarray]:
        rng = np.random.default_rng(seed)
        points = rng.uniform((0, 0), size, (3000, 2))
        angles = rng.normal(0.6, 0.2, 3000)
        voters = Voters.of(points, np.stack([np.cos(angles), np.sin(angles)], axis=1), size[1])
        lams = -1e-6 + width * np.linspace(-5e-7, 3e-7, 4)
        xs, ys = (c + width * np.linspace(-40, 50, 4) for c in (970.0, 530.0))
        votes = plain_hewg.Votes.of(voters)
        return hewg(voters, lams, xs, ys), plain_hewg.grid(votes, lams, xs, ys)

    found = [grids(seed) for seed in range(6)]
    for ours, plain in found:
        assert ours.min() == pytest.approx(plain.min(), abs=1e-9)
        assert plain[np.unravel_index(ours.argmin(), ours.shape)] == pytest.approx(
            plain.min(), abs=1e-9
        )
    monkeypatch.setattr(AGAIN, lambda *grid: None)
    rounded = [abs(grids(seed)[0] - plain).max() for seed, (_, plain) in enumerate(found)]
    assert max(rounded) > 1e-5, "votes must lie near a border for this to tell"


def test_a_cell_has_the_articles_size() -> None:
    # Two lines a little less than a cell apart share one, and two a little more do not.
    def entropy_of(degrees: float, px: float) -> float:
        phi = np.deg2rad(np.repeat([10.5, 10.5 + degrees], 50))
        normal = np.stack([np.cos(phi), np.sin(phi)], axis=1)
        offset = np.repeat([100.5, 100.5 + px], 50)
        along = np.tile(np.linspace(-100, 100, 50), 2)
        tangent = np.stack([-normal[:, 1], normal[:, 0]], axis=1)
        points = (360, 270) + offset[:, None] * normal + along[:, None] * tangent
        voters = Voters.of(points, normal, 540, spread=0)
        return hewg(voters, np.array([0.0]), np.array([360.0]), np.array([270.0])).item()

    one_degree = 180 / ANGLES
    assert entropy_of(0, 0) == pytest.approx(0, abs=1e-6)
    assert entropy_of(0.4 * one_degree, 1.0) == pytest.approx(0, abs=1e-6)
    assert entropy_of(0.6 * one_degree, 0) == pytest.approx(np.log(2), abs=1e-6)
    assert entropy_of(0, 2.0) == pytest.approx(np.log(2), abs=1e-6)


@pytest.mark.parametrize("times", [2, 4])
def test_a_larger_picture_of_the_same_has_the_same_entropies(times: int) -> None:
    """Cells grow with the frame: powers of two change no digit."""
    points, gradients, _ = edges_on_lines(TRUTH)
    lams, xs, ys = TRUTH.lam * np.array([0.8, 1.0]), np.array([360.0, 366.0]), np.array([262.0])
    small = hewg(Voters.of(points, gradients, 540), lams, xs, ys)
    large = Voters.of(times * points, gradients, times * 540)
    assert np.array_equal(hewg(large, lams / times**2, times * xs, times * ys), small)


def test_half_a_turn_of_directions_begins_where_there_is_room_to_both_sides() -> None:
    """A gap at edges' directions is no room for noise, though nothing points there."""
    middles = (np.arange(SEAMS) + 0.5) * np.pi / SEAMS
    counts = np.full(SEAMS, 50)
    counts[10:12] = 0
    counts[24:27] = 3
    assert _emptiest(np.repeat(middles, counts)) == pytest.approx(middles[25])
    # Where directions begin anew there is room, too.
    assert _emptiest(np.repeat(middles, np.roll(counts, -25))) == pytest.approx(middles[0])


def test_a_vote_that_rounding_moves_is_made_up_for() -> None:
    """Models are counted again that lie as near to the least as the worst of such votes moves any."""
    gains = gains_of(MOST_VOTERS_FOR_START)
    # From the fullest cell there may be to an empty one.
    assert np.diff(gains).max() < ROUNDED


def entropy_of(points: np.ndarray, normals: np.ndarray, **spread: float) -> float:
    """Under no distortion and the centre (360, 270)."""
    voters = Voters.of(points, normals, 540, **spread)
    return hewg(voters, np.array([0.0]), np.array([360.0]), np.array([270.0])).item()


def test_where_the_borders_of_cells_lie_tells_no_line_from_another() -> None:
    # 500 votes for one line, which noise scatters by a fifth of a cell.
    rng = np.random.default_rng(0)
    phi = np.deg2rad(40.0 + rng.normal(0, 0.2, 500))
    along = np.linspace(-100, 100, 500)

    def entropies(**spread: float) -> list[float]:
        found = []
        for i in range(8):
            # Across a cell in eight steps, of an eighth of its 2 px and of its degree.
            normal = np.array([np.cos(phi + np.deg2rad(i / 8)), np.sin(phi + np.deg2rad(i / 8))]).T
            tangent = np.stack([-normal[:, 1], normal[:, 0]], axis=1)
            points = (360, 270) + (100 + i / 4) * normal + along[:, None] * tangent
            found.append(entropy_of(points, normal, **spread))
        return found

    assert np.ptp(entropies()) < 0.15
    assert np.ptp(entropies(spread=0)) > 0.7


@pytest.mark.parametrize("degrees", [0.0, 45.0, 90.0, 135.0])
def test_noise_parts_no_line_in_two(degrees: float) -> None:
    # The normals of parallel lines waver about a direction, also about that where an angle begins anew.
    phi = np.deg2rad(degrees + np.random.default_rng(0).normal(0, 0.3, 2000))
    normal = np.stack([np.cos(phi), np.sin(phi)], axis=1)
    offset = np.repeat([-120.0, -40.0, 40.0, 120.0], 500)
    upright = np.deg2rad(degrees)
    along = np.tile(np.linspace(-5, 5, 500), 4)[:, None] * (-np.sin(upright), np.cos(upright))
    points = (360, 270) + offset[:, None] * (np.cos(upright), np.sin(upright)) + along
    signs = np.random.default_rng(1).choice([-1, 1], 2000)[:, None]
    found = entropy_of(points, normal * signs)
    # Each line spreads by the same kernel; where all were parted in two, ln 2 would come on top.
    assert found == pytest.approx(entropy_of(points, normal), abs=1e-9)
    assert found < np.log(4) + 2.2
