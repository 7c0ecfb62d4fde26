"""Algorithm 1 on costs whose minimum is known."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from endocal.calibration.search import STILL_MANY, Region, Scout, search

REGION = Region((-1e-5, -1e-7), (300.0, 420.0), (220.0, 320.0))


def bowl(lam: float, x: float, y: float):
    def cost(lams: np.ndarray, xs: np.ndarray, ys: np.ndarray) -> np.ndarray:
        a = ((lams - lam) / 1e-6)[:, None, None] ** 2
        return a + ((xs - x) / 10)[:, None] ** 2 + ((ys - y) / 10) ** 2

    return cost


@given(
    st.floats(-1e-5, -1e-7),
    st.floats(300, 420),
    st.floats(220, 320),
    st.integers(4, 10),
)
def test_it_finds_the_minimum_of_a_bowl(lam: float, x: float, y: float, samples: int) -> None:
    found = search(bowl(lam, x, y), REGION, samples, 1e-9, 20)
    # What is left of a range after a round, at most: two steps of samples - 1.
    share = (2 / (samples - 1)) ** found.rounds
    assert abs(found.params[0] - lam) < 1e-9
    assert found.params[1] == pytest.approx(x, abs=share * 120)
    assert found.params[2] == pytest.approx(y, abs=share * 100)


def test_it_ends_with_the_round_that_leaves_less_than_epsilon() -> None:
    # 10 samples leave 2/9 of a range: 9.9e-6 (2/9)^7 is the first below 1e-9, after 7 rounds.
    ranges = []

    def cost(lams: np.ndarray, xs: np.ndarray, ys: np.ndarray) -> np.ndarray:
        ranges.append(lams[-1] - lams[0])
        return bowl(-5e-6, 360, 270)(lams, xs, ys)

    found = search(cost, REGION, 10, 1e-9, 20)
    assert found.rounds == len(ranges) == 7
    assert ranges[1:] == pytest.approx([r * 2 / 9 for r in ranges[:-1]])


def test_it_ends_after_the_rounds_it_was_given() -> None:
    assert search(bowl(-5e-6, 360, 270), REGION, 10, 1e-30, 4).rounds == 4


def test_a_range_of_one_value_has_one_sample() -> None:
    def cost(lams: np.ndarray, xs: np.ndarray, ys: np.ndarray) -> np.ndarray:
        assert len(xs) == len(ys) == 1
        return bowl(-5e-6, 360, 270)(lams, xs, ys)

    region = Region(REGION.lam, (371.0, 371.0), (255.5, 255.5))
    assert list(search(cost, region, 10, 1e-9, 20).params[1:]) == [371.0, 255.5]


def test_it_stays_within_its_region() -> None:
    found = search(bowl(-1e-4, 500, 100), REGION, 10, 1e-9, 20)
    assert list(found.params) == [-1e-5, 420.0, 220.0]


def test_the_best_of_all_rounds_is_returned() -> None:
    # A needle that only the first round hits.
    def cost(lams: np.ndarray, xs: np.ndarray, ys: np.ndarray) -> np.ndarray:
        costs = bowl(-5e-6, 360, 270)(lams, xs, ys)
        costs[np.isclose(lams, -1e-5, rtol=1e-12)] -= 1000 * (len(calls) == 0)
        calls.append(1)
        return costs

    calls: list[int] = []
    found = search(cost, REGION, 10, 1e-9, 20)
    assert found.params[0] == -1e-5


def valley(lam: float, x: float, y: float):
    """A narrow valley askew to the axes, deepest at one point: its walls hide the floor from wide steps."""

    def cost(lams: np.ndarray, xs: np.ndarray, ys: np.ndarray) -> np.ndarray:
        a = ((lams - lam) / 1e-6)[:, None, None]
        b = ((xs - x) / 10)[:, None]
        off = a - 0.15 * b + 0 * ys
        return np.minimum(np.abs(off) / 0.05, 1) + 0.02 * np.hypot(b, (ys - y) / 10)

    return cost


def test_a_valley_that_the_first_round_leaves_is_found_again() -> None:
    cost = valley(-4.03e-6, 371.0, 262.0)
    first = search(cost, REGION, 10, 1e-9, 20)
    found = search(cost, REGION, 10, 1e-9, 20, again=3)
    assert found.cost < first.cost - 0.01
    assert found.rounds > first.rounds
    assert np.hypot(found.params[1] - 371, found.params[2] - 262) < 3
    assert np.hypot(first.params[1] - 371, first.params[2] - 262) > 5


def test_it_is_done_again_only_while_that_finds_better() -> None:
    first = search(bowl(-5e-6, 360, 270), REGION, 10, 1e-9, 20)
    calls = []

    def cost(lams: np.ndarray, xs: np.ndarray, ys: np.ndarray) -> np.ndarray:
        calls.append(1)
        return np.maximum(bowl(-5e-6, 360, 270)(lams, xs, ys), first.cost)

    found = search(cost, REGION, 10, 1e-9, 20, again=5)
    assert list(found.params) == list(first.params)
    # One more search, around what was found, and no third.
    assert first.rounds < len(calls) == found.rounds < 2 * first.rounds


def test_what_is_as_good_is_nothing_better() -> None:
    def flat(lams: np.ndarray, xs: np.ndarray, ys: np.ndarray) -> np.ndarray:
        return np.zeros((len(lams), len(xs), len(ys)))

    once = search(flat, REGION, 5, 1e-9, 20, again=1)
    often = search(flat, REGION, 5, 1e-9, 20, again=5)
    assert once.rounds == often.rounds
    assert list(once.params) == list(often.params)


@given(st.floats(-1e-5, -1e-7), st.floats(300, 420), st.floats(220, 320), st.floats(0, 1))
def test_a_scout_that_is_off_by_less_than_its_margin_changes_nothing(
    lam: float, x: float, y: float, off: float
) -> None:
    cost = bowl(lam, x, y)
    measured = []

    def measure(
        lams: np.ndarray, xs: np.ndarray, ys: np.ndarray, chosen: np.ndarray | None = None
    ) -> np.ndarray:
        costs = cost(lams, xs, ys)
        measured.append(1.0 if chosen is None else float(chosen.mean()))
        return costs if chosen is None else np.where(chosen, costs, np.inf)

    def rough(lams: np.ndarray, xs: np.ndarray, ys: np.ndarray, _: object = None) -> np.ndarray:
        costs = cost(lams, xs, ys)
        return costs + off * np.sin(1e3 * costs)

    whole = search(cost, REGION, 10, 1e-9, 20)
    found = search(measure, REGION, 10, 1e-9, 20, scout=Scout(rough, 2 * off))
    assert list(found.params) == list(whole.params)
    assert (found.cost, found.rounds) == (whole.cost, whole.rounds)
    # It goes ahead until it leaves too much to be worth it.
    ahead = [share for share in measured if share < 1]
    assert measured[: len(ahead)] == ahead
    assert all(share <= STILL_MANY for share in ahead[:-1])


def test_a_scout_goes_ahead_while_it_leaves_little() -> None:
    asked = []

    def rough(lams: np.ndarray, xs: np.ndarray, ys: np.ndarray, _: object = None) -> np.ndarray:
        asked.append(lams[-1] - lams[0])
        return bowl(-5e-6, 360, 270)(lams, xs, ys)

    def measure(
        lams: np.ndarray, xs: np.ndarray, ys: np.ndarray, chosen: np.ndarray | None = None
    ) -> np.ndarray:
        costs = bowl(-5e-6, 360, 270)(lams, xs, ys)
        return costs if chosen is None else np.where(chosen, costs, np.inf)

    # A bowl of which the first round's grid has costs to 100, the second's to 5 and the third's to 0.3.
    search(measure, REGION, 10, 1e-9, 20, scout=Scout(rough, 0.2))
    assert len(asked) == 3
