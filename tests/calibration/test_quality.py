from dataclasses import replace

import pytest

from endocal.calibration import quality as q
from endocal.calibration.fit.uncertainty import NEAR_FOLD
from endocal.calibration.quality import judge, shows_no_pattern

from .evidence import GOOD


def test_sound_evidence_is_good() -> None:
    quality = judge(GOOD)
    assert quality.verdict == "good"
    assert quality.reasons == ()
    assert (quality.lines, quality.points, quality.rms) == (25, 8000, 0.1)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"lines": 6}, "few lines"),
        ({"reach": 120.0}, "poor coverage"),
        ({"second_lost": True}, "this is the one-parameter model"),
        ({"bend": 0.3}, "residuals above noise"),
        ({"rms": 0.9}, "edges are noisy"),
        ({"outlying": 0.3}, "30% of the points do not follow"),
        ({"rms": 0.2, "board": False}, "edges are noisy"),
        ({"explained": 0.03}, "is this a pattern"),
        ({"explained": 0.2, "board": False}, "is this a pattern"),
        ({"lam_sigma": 1e-7}, "weakly determined"),
        ({"lam_sigma": 1e-6}, "within its uncertainty of zero"),
        ({"lam": -1e-17, "lam_sigma": 1e-43}, "within its uncertainty of zero"),  # a drawing
        ({"center_sigma": 4.0}, "centre is weakly determined (one standard deviation: 4.0 px)"),
        ({"center_sigma": 4.0, "board": False, "explained": 0.9}, "show lines in two directions"),
        ({"center_sigma": 4.0, "bend": 0.061}, "departs from the model, by 0.061 px here"),
        ({"center_sigma": 30.0}, "centre is weakly determined (it may be anywhere"),
        ({"fold_radius": 303.0}, "at its bound"),
        ({"astray": 4.0}, "cropped"),
        ({"fold_radius": 350.0}, "inside the visible content"),
        ({"pictures": 2, "differing": 1}, "the two pictures do not go together"),
        ({"pictures": 5, "differing": 4}, "5 pictures do not go together, number 4 least"),
    ],
)
def test_each_doubt_is_named(change: dict, reason: str) -> None:
    quality = judge(replace(GOOD, **change))
    assert quality.verdict == "doubtful"
    assert len(quality.reasons) == 1
    assert reason in quality.reasons[0]


# px of a 540-line frame, in that of GOOD.
SCALE = GOOD.short_side / 540


@pytest.mark.parametrize(
    ("name", "threshold", "beyond"),
    [
        ("reach", q.POOR_COVERAGE * GOOD.content_radius, -1),
        ("center_sigma", q.WEAK_CENTER * GOOD.short_side, 1),
        ("lam_sigma", q.WEAK_LAMBDA * abs(GOOD.lam), 1),
        ("bend", q.BENT * SCALE, 1),
        ("rms", q.ROUGH * SCALE, 1),
        ("outlying", q.MANY_OUTLYING, 1),
        ("explained", q.LITTLE_EXPLAINED, -1),
        ("astray", q.ASTRAY, 1),
        ("fold_radius", GOOD.content_radius, -1),
    ],
)
def test_the_verdict_turns_at_the_thresholds(name: str, threshold: float, beyond: int) -> None:
    for way, verdict in ((-beyond, "good"), (beyond, "doubtful")):
        at = replace(GOOD, **{name: threshold * (1 + 1e-6 * way)})
        assert judge(at).verdict == verdict
        assert len(judge(at).reasons) == (verdict == "doubtful")


@pytest.mark.parametrize(
    ("name", "threshold", "beyond"),
    [
        ("rms", q.FAILED_ROUGH * SCALE, 1),
        ("explained", q.FAILED_EXPLAINED, -1),
        ("astray", q.FAILED_ASTRAY, 1),
    ],
)
def test_it_fails_from_the_thresholds_on(name: str, threshold: float, beyond: int) -> None:
    for way, verdict in ((-beyond, "doubtful"), (beyond, "failed")):
        assert judge(replace(GOOD, **{name: threshold * (1 + 1e-6 * way)})).verdict == verdict


def test_so_many_lines_are_enough() -> None:
    verdicts = [judge(replace(GOOD, lines=n)).verdict for n in range(q.FEW_LINES + 1)]
    doubtful = q.FEW_LINES - q.FAILED_LINES
    assert verdicts == ["failed"] * q.FAILED_LINES + ["doubtful"] * doubtful + ["good"]


def test_without_a_board_it_must_be_straighter() -> None:
    alone = replace(GOOD, board=False)
    limit, most = (share * SCALE for share in (q.ROUGH_WITHOUT_BOARD, q.FAILED_WITHOUT_BOARD))
    for rms, verdict in ((limit, "good"), (most, "doubtful")):
        assert judge(replace(alone, rms=rms * (1 - 1e-6))).verdict == verdict
        assert judge(replace(alone, rms=rms * (1 + 1e-6))).verdict != verdict
    for way, verdict in ((1, "good"), (-1, "doubtful")):
        explained = q.LITTLE_WITHOUT_BOARD * (1 + 1e-6 * way)
        assert judge(replace(alone, explained=explained)).verdict == verdict


def test_lambda_differs_from_zero_from_so_many_standard_deviations_on() -> None:
    """A drawing leaves no noise: then one of them is what moves the farthest points by so much."""
    told = q.FINEST / GOOD.reach**3
    weak = GOOD.lam / q.SIGNIFICANT
    for way, zero in ((-1, False), (1, True)):
        by_noise = replace(GOOD, lam_sigma=abs(weak) * (1 + 1e-6 * way))
        assert ("zero" in judge(by_noise).reasons[0]) is zero
        drawn = replace(GOOD, lam_sigma=0.0, lam=-q.SIGNIFICANT * told * (1 - 1e-6 * way))
        assert (judge(drawn).verdict == "doubtful") is zero


def test_the_bound_of_lambda_is_where_it_folds_right_behind_the_lines() -> None:
    seen = replace(GOOD, reach=GOOD.content_radius)
    for way, verdict in ((1, "good"), (-1, "doubtful")):
        fold = NEAR_FOLD * seen.reach * (1 + 1e-6 * way)
        assert judge(replace(seen, fold_radius=fold)).verdict == verdict


def test_what_outlies_where_pictures_differ_has_its_reason_already() -> None:
    """Under the model of one picture the other's points do not follow their lines: once is said enough."""
    apart = replace(GOOD, pictures=2, differing=1)
    assert judge(replace(apart, outlying=0.4)).reasons == judge(apart).reasons
    assert len(judge(replace(GOOD, outlying=0.4)).reasons) == 1


def test_a_given_centre_may_be_what_is_wrong() -> None:
    given = replace(GOOD, center_sigma=None)
    assert judge(given).verdict == "good"
    for rough in ({"bend": 0.3}, {"rms": 4.0}):
        assert "the centre that was given" in judge(replace(given, **rough)).reasons[0]
        assert "given" not in judge(replace(GOOD, **rough)).reasons[0]


@pytest.mark.parametrize(
    ("change", "none"),
    [
        ({}, False),
        ({"board": False}, False),
        ({"rms": 0.5}, False),
        ({"rms": 0.5, "board": False}, True),
        ({"rms": 0.5, "board": False, "short_side": 1080.0}, False),
        ({"rms": 0.2, "explained": 0.2, "board": False}, True),
        ({"explained": 0.01}, False),
        ({"explained": 0.01, "board": False}, True),
    ],
)
def test_what_shows_no_pattern_is_what_would_fail_alone(change: dict, none: bool) -> None:
    seen = replace(GOOD, **change)
    assert shows_no_pattern(seen) is none
    assert not none or judge(seen).verdict == "failed"


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"lines": 3}, "only 3 straight lines"),
        ({"rms": 0.2, "explained": 0.2, "board": False}, "20% of the edges and 0.20 px"),
        ({"rms": 4.0}, "does not fit"),
        ({"explained": 0.01}, "only 1% of the edges"),
        ({"astray": 8.0}, "far from the middle"),
        ({"rms": 0.5, "board": False}, "no chessboard seen"),
        ({"lam_sigma": 1e-6, "lines": 6, "board": False}, "no pattern seen"),
        ({"lam_sigma": 1e-6, "explained": 0.1, "board": False}, "no pattern seen"),
    ],
)
def test_what_cannot_be_trusted_fails(change: dict, reason: str) -> None:
    quality = judge(replace(GOOD, **change))
    assert quality.verdict == "failed"
    assert any(reason in r for r in quality.reasons)
