"""The page's list of checks and the verdict rest on the same limits."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from endocal.calibration.quality import Evidence, judge
from endocal.report.checks import checks
from tests.calibration.evidence import GOOD


def met(evidence: Evidence) -> dict[str, bool]:
    return {check.what: check.met for check in checks(evidence)}


@pytest.mark.parametrize(
    ("change", "what"),
    [
        ({"lines": 6}, "Straight lines found"),
        ({"reach": 120.0}, "How far out the lines reach"),
        ({"rms": 0.9}, "How straight the lines are now"),
        ({"outlying": 0.3}, "Points that do not follow their lines"),
        ({"rms": 0.5, "board": False}, "How straight the lines are now"),
        ({"bend": 0.3}, "How bent they stay, beyond noise"),
        ({"explained": 0.03}, "Edges that lie on these lines"),
        ({"lam_sigma": 1e-7}, "How surely the distortion is known"),
        ({"center_sigma": 4.0}, "How surely the centre is known"),
        ({"astray": 4.0}, "Where the centre lies"),
        ({"fold_radius": 350.0}, "Where the correction would fold"),
    ],
)
def test_what_the_verdict_doubts_is_not_met(change: dict[str, Any], what: str) -> None:
    assert all(met(GOOD).values())
    evidence = replace(GOOD, **change)
    assert judge(evidence).verdict != "good"
    assert [name for name, good in met(evidence).items() if not good] == [what]


@given(
    lines=st.integers(0, 40),
    rms=st.floats(0, 3),
    bend=st.floats(0, 1),
    outlying=st.floats(0, 1),
    lam=st.floats(-1e-5, 1e-5),
    lam_sigma=st.none() | st.floats(0, 1e-6),
    center_sigma=st.none() | st.floats(0, 100),
    reach=st.floats(1, 500),
    fold_radius=st.floats(1, 1000) | st.just(float("inf")),
    short_side=st.floats(64, 4000),
    explained=st.floats(0, 1),
    board=st.booleans(),
    astray=st.floats(0, 10),
)
def test_all_is_met_where_the_verdict_is_good(**values: Any) -> None:
    evidence = replace(GOOD, **values)
    if judge(evidence).verdict == "good":
        assert all(met(evidence).values())
