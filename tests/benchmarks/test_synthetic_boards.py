"""The accuracy benchmark counts what it says: errors, spreads, verdicts, and silence."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from endocal.benchmarks import synthetic_boards
from endocal.benchmarks.synthetic_boards import CRASHED, REFUSED, Outcome, run_board, summarise
from endocal.calibration.result import Calibration, Quality, Uncertainty
from endocal.errors import CalibrationError
from endocal.synth.random import random_board

# A small picture, so that it is quick.
SEED = next(s for s in range(100) if random_board(s).model.size == (400, 400))
SOUND = Outcome(
    seed=1,
    size=(400, 400),
    pattern="chessboard",
    strength=-0.5,
    verdict="good",
    reasons=(),
    lam_error=0.001,
    center_error=0.1,
    z=(1.0, 0.5, -0.5),
    seconds=1.0,
)


def found(seed: int, lam_factor: float, shift: float, verdict: str = "good") -> Calibration:
    """What would be a calibration of that board with these errors."""
    model = random_board(seed).model
    x, y = model.center
    off = replace(model, lam=model.lam * lam_factor, center=(x + shift, y))
    sigma = Uncertainty(abs(model.lam) * 0.01, (0.5, 0.5))
    return Calibration(off, sigma, quality=Quality(verdict, ("why",)))


def test_the_errors_are_those_of_the_model(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(synthetic_boards, "calibrate", lambda p, spec: found(SEED, 1.03, 1.0))
    outcome = run_board(SEED)
    assert outcome.lam_error == pytest.approx(0.03)
    assert outcome.center_error == pytest.approx(1.0)
    assert outcome.z == pytest.approx((-3.0, 2.0, 0.0))  # lambda is negative: more of it lies below
    assert (outcome.verdict, outcome.reasons, outcome.silent) == ("good", ("why",), True)


@pytest.mark.parametrize(
    ("error", "verdict"), [(CalibrationError("no lines"), REFUSED), (IndexError("7"), CRASHED)]
)
def test_a_refusal_and_a_crash_are_infinitely_wrong_and_told_apart(
    monkeypatch: pytest.MonkeyPatch, error: Exception, verdict: str
) -> None:
    def fail(picture: object, spec: object) -> Calibration:
        raise error

    monkeypatch.setattr(synthetic_boards, "calibrate", fail)
    outcome = run_board(SEED)
    assert outcome.verdict == verdict
    assert str(error) in outcome.reasons[0]
    assert outcome.lam_error == outcome.center_error == math.inf
    assert not outcome.silent
    data = json.dumps([outcome.data(), summarise([outcome]).data()], allow_nan=False)
    assert '"lam_error": null' in data


def test_the_strength_is_within_the_distribution() -> None:
    # lam R^2 lies in -1.5 ... -0.05 by the corner's radius, and above -1 by what is visible.
    strengths = [synthetic_boards.strength_of(random_board(seed)) for seed in range(60)]
    assert all(-1 < s < -0.03 for s in strengths)


def test_the_summary_of_a_set() -> None:
    rng = np.random.default_rng(0)
    z = rng.normal(0, (1.0, 2.0, 0.5), (1000, 3))
    outcomes = [
        replace(
            SOUND,
            seed=i,
            lam_error=(i + 1) / 1e5,
            center_error=(i + 1) / 1e3,
            z=tuple(z[i]),
            verdict="doubtful" if i < 300 else "good",
        )
        for i in range(1000)
    ]
    summary = summarise([*outcomes, replace(SOUND, seed=5000, lam_error=0.021)])
    assert summary.boards == 1001
    assert summary.verdicts == {"good": 701, "doubtful": 300}
    assert summary.lam_median == pytest.approx(0.005, rel=0.01)
    assert summary.lam_p95 == pytest.approx(0.0095, rel=0.01)
    assert summary.center_median == pytest.approx(0.5, rel=0.01)
    assert summary.z == pytest.approx((1, 2, 0.5), rel=0.1)
    assert summary.silent == (5000,)


def test_wrong_and_doubtful_is_not_silent() -> None:
    assert replace(SOUND, lam_error=0.021).silent
    assert not replace(SOUND, lam_error=0.5, verdict="doubtful").silent
    assert not replace(SOUND, lam_error=0.019).silent


def test_a_refusal_among_many_moves_the_quantiles_and_makes_no_nan() -> None:
    refused = replace(SOUND, verdict=REFUSED, lam_error=math.inf, center_error=math.inf, z=None)
    summary = summarise([*[SOUND] * 18, refused, refused])
    assert summary.lam_median == SOUND.lam_error
    assert summary.lam_p95 == math.inf


def test_processes_make_no_difference() -> None:
    seen: list[Outcome] = []
    alone, together = (synthetic_boards.run([SEED], processes, seen.append) for processes in (1, 2))
    assert [replace(o, seconds=0) for o in alone] == [replace(o, seconds=0) for o in together]
    assert alone[0].verdict != CRASHED
    assert seen == [*alone, *together]


def test_the_worst_come_first() -> None:
    errors = [(0.1, 3.0), (math.inf, math.inf), (0.3, 1.0), (0.2, 9.0)]
    outcomes = [
        replace(SOUND, seed=i, lam_error=lam, center_error=center)
        for i, (lam, center) in enumerate(errors)
    ]
    assert [o.seed for o in synthetic_boards.worst(outcomes, 2)] == [1, 2, 3]
