from dataclasses import replace

import pytest

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
