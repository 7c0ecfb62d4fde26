"""Calibrations and zoom tables: what is written reads back, and what is wrong is named."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from endocal.boundary.circle import Boundary
from endocal.calibration.result import (
    FEW_OUTLYING,
    VERDICTS,
    Calibration,
    Quality,
    Source,
    SourceImage,
    Uncertainty,
)
from endocal.errors import InputError, OutputError
from endocal.files import dumps, load, loads, save
from endocal.model import DivisionModel
from endocal.zoom.table import Setting, SettingSource, ZoomTable

SIZE = (768, 576)

CALIBRATION = Calibration(
    DivisionModel(-2.8312345678e-6, (388.6123456, 275.7), SIZE),
    Uncertainty(1.2345e-9, (0.1123, 0.0923)),
    Boundary((383.0, 287.5), 712.0, 331000.0, 0.83),
    Quality("doubtful", ("few lines", 'a "quoted" one'), 26, 8120, 2.31, 0.13, 6.234, 0.12),
    Source("hewg", True, (SourceImage("cal.png", "0f" * 32),), "0.1.0"),
)
TABLE = ZoomTable(
    (
        Setting(
            -2.9644e-5, (360.0, 270.0), 210.0, 34000.0, source=SettingSource("F1.png", "0" * 64)
        ),
        Setting(-1.2742e-5, (361.25, 270.0), 312.0),
    ),
    (720, 540),
)

names = st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=20)
positive = st.floats(1e-12, 1e3)


@st.composite
def calibrations(draw: st.DrawFn) -> Calibration:
    model = DivisionModel(
        lam=draw(st.floats(-9e-7, 9e-7)),
        center=(draw(st.floats(300, 470)), draw(st.floats(200, 370))),
        size=SIZE,
        pixel_aspect=draw(st.sampled_from([1.0, 64 / 45])),
        lam2=draw(st.one_of(st.just(0.0), st.floats(-1e-14, 1e-14))),
    )
    return Calibration(
        model,
        draw(
            st.none()
            | st.builds(Uncertainty, positive, st.tuples(positive, positive), st.none() | positive)
        ),
        draw(
            st.none()
            | st.builds(
                Boundary,
                st.tuples(st.floats(300, 400), st.floats(200, 300)),
                st.floats(10, 900),
                st.floats(0, 1e6),
                st.floats(0, 1),
            )
        ),
        draw(
            st.none()
            | st.builds(
                Quality,
                st.sampled_from(VERDICTS),
                st.lists(names, max_size=3).map(tuple),
                st.integers(0, 99),
                st.integers(0, 99999),
                st.none() | positive,
                st.none() | positive,
                st.none() | positive,
                st.just(0.0) | st.floats(FEW_OUTLYING, 1),
            )
        ),
        draw(
            st.none()
            | st.builds(
                Source,
                names,
                st.booleans(),
                st.lists(st.builds(SourceImage, names, names), max_size=3).map(tuple),
                names,
            )
        ),
    )


@st.composite
def tables(draw: st.DrawFn) -> ZoomTable:
    constant = draw(st.floats(-1.4, 0.8))
    first = draw(st.floats(100, 300))
    ratios = draw(st.lists(st.floats(1.05, 1.9), min_size=1, max_size=4))
    diameters = [first * math.prod(ratios[:i]) for i in range(len(ratios) + 1)]
    settings = [
        Setting(
            constant / d**2,
            (draw(st.floats(300, 400)), draw(st.floats(200, 300))),
            d,
            draw(st.none() | st.floats(1, 1e6)),
            draw(st.sampled_from([0.0, 0.05])) / d**4,
            draw(st.none() | st.builds(SettingSource, names, st.sampled_from(["", "a" * 64]))),
            draw(st.none() | st.tuples(st.floats(300, 400), st.floats(200, 300))),
        )
        for d in diameters
    ]
    try:
        return ZoomTable(tuple(settings), (720, 540))
    except InputError:
        assume(False)
        raise


@given(calibrations() | tables())
def test_round_trip(obj: Calibration | ZoomTable) -> None:
    text = dumps(obj)
    again = loads(text)
    assert dumps(again) == text
    assert loads(dumps(again)) == again
    assert all(line.isprintable() for line in text.split("\n"))


@given(calibrations())
def test_numbers_are_rounded_well_below_their_uncertainty(calibration: Calibration) -> None:
    read = loads(dumps(calibration))
    assert isinstance(read, Calibration)
    before, after, u = calibration.model, read.model, calibration.uncertainty
    for old, new, sigma in (
        (before.lam, after.lam, u.lam if u else 0.0),
        (before.lam2, after.lam2, (u.lam2 or 0.0) if u else 0.0),
        (before.center[0], after.center[0], u.center[0] if u else 0.0),
        (before.center[1], after.center[1], u.center[1] if u else 0.0),
    ):
        # A value smaller than its uncertainty keeps one digit: half of it is lost at most.
        coarse = abs(old) / 2 if sigma > abs(old) else 0.0
        assert abs(new - old) <= max(sigma / 100, abs(old) * 1e-8, coarse)


def test_the_same_object_gives_the_same_bytes(tmp_path: Path) -> None:
    for name in ("a.toml", "b.toml"):
        save(CALIBRATION, tmp_path / name)
    first, second = ((tmp_path / n).read_bytes() for n in ("a.toml", "b.toml"))
    assert first == second
    assert str(tmp_path).encode() not in first


def test_numerical_noise_does_not_reach_the_file() -> None:
    # What another order of summation does: the last of the sixteen digits.
    model = CALIBRATION.model
    noisy = replace(
        CALIBRATION,
        model=replace(
            model, lam=model.lam * (1 + 1e-13), center=tuple(v * (1 + 1e-13) for v in model.center)
        ),
    )
    assert dumps(noisy) == dumps(CALIBRATION)


def test_names_of_any_kind_survive() -> None:
    for name in (
        "a b.png",
        "naïve 内視鏡.png",
        "new\nline.png",
        "50%.png",
        'q"uote\\.png',
        "\x7f\t.png",
    ):
        source = Source(images=(SourceImage(name, ""),))
        read = loads(dumps(replace(CALIBRATION, source=source)))
        assert isinstance(read, Calibration)
        assert read.source == source


def test_save_keeps_what_is_there(tmp_path: Path) -> None:
    path = tmp_path / "cal.toml"
    path.write_text("precious")
    with pytest.raises(OutputError, match="exists already"):
        save(CALIBRATION, path)
    assert path.read_text() == "precious"
    save(TABLE, path, overwrite=True)
    assert load(path) == TABLE


def test_a_lambda_may_fold_beyond_the_visible_circle() -> None:
    # A circular fisheye: at the frame's corner the map is long past its pole, in the circle it is sound.
    frame, circle = (748, 480), Boundary((374.0, 240.0), 470.0, 170000.0, 1.0)
    model = DivisionModel(-1 / 300**2, (374.0, 240.0), frame)
    read = loads(dumps(Calibration(model, boundary=circle)))
    assert isinstance(read, Calibration)
    assert read.boundary == circle
    with pytest.raises(
        InputError, match=r"folds the picture over 300\.0 px .* give the visible circle"
    ):
        dumps(Calibration(model))
    too_wide = replace(circle, diameter=601.0)
    with pytest.raises(InputError, match="inside its own visible circle"):
        dumps(Calibration(model, boundary=too_wide))


def test_a_usable_radius_ends_what_has_to_hold() -> None:
    model = DivisionModel(-1 / 300**2, (374.0, 240.0), (748, 480))
    read = loads(dumps(Calibration(model, usable_radius=290.04)))
    assert isinstance(read, Calibration)
    assert read.usable_radius == 290.0
    with pytest.raises(InputError, match=r"inside its own usable_radius, which reaches 301\.0 px"):
        dumps(Calibration(model, usable_radius=301.0))


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_what_is_not_a_number_is_never_written(tmp_path: Path, bad: float) -> None:
    with pytest.raises(InputError, match="not a finite number"):
        save(replace(CALIBRATION, uncertainty=Uncertainty(bad, (0.1, 0.1))), tmp_path / "cal.toml")
    assert CALIBRATION.boundary is not None
    with pytest.raises(InputError, match="not a finite number"):
        save(
            replace(CALIBRATION, boundary=replace(CALIBRATION.boundary, area=bad)),
            tmp_path / "b.toml",
        )
    assert list(tmp_path.iterdir()) == []
