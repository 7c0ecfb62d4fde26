"""Options go with a calibration, and come back as they were."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import pytest

from endocal.calibration.recorded import ELSEWHERE, RECORDED, options_of, spec_of
from endocal.calibration.result import Calibration, Source, Uncertainty
from endocal.calibration.spec import CalibrationSpec
from endocal.errors import UsageError
from endocal.files import dumps, loads
from endocal.model import DivisionModel

UNUSUAL: dict[str, Any] = {
    "center": (351.25, 262.5),
    "samples": 8,
    "epsilon": 1e-8,
    "max_rounds": 12,
    "center_region": 0.2,
    "sobel": 15,
    "roi": (10, 20, 300, 200),
    "lines": (((1.5, 2.0), (30.0, 4.25), (60.0, 8.0)), ((5.0, 9.0), (6.0, 40.0), (8.0, 70.0))),
}


def recorded(spec: CalibrationSpec) -> Calibration:
    lam2 = 1e-13 if spec.model == "division2" else 0.0
    model = DivisionModel(-1e-6, (360.0, 270.0), (720, 540), spec.aspect, lam2)
    made = Calibration(model)
    options = options_of(spec, made)
    return replace(made, source=Source(spec.method, spec.refine, options=options))


@pytest.mark.parametrize("name", UNUSUAL)
def test_an_option_comes_back_through_the_file(name: str) -> None:
    spec = CalibrationSpec(method="wang", **{name: UNUSUAL[name]})
    text = dumps(recorded(spec))
    found = loads(text)
    assert isinstance(found, Calibration)
    # What pixels were taken for holds, whatever the pictures' files say by then.
    assert spec_of(found) == replace(spec, pixel_aspect=1.0)
    assert dumps(found) == text


@pytest.mark.parametrize(("refine", "model"), [(False, "division"), (True, "division2")])
def test_all_options_come_back_at_once(refine: bool, model: str) -> None:
    spec = CalibrationSpec(method="wang", refine=refine, model=model, pixel_aspect=1.25, **UNUSUAL)
    found = loads(dumps(recorded(spec)))
    assert isinstance(found, Calibration)
    assert spec_of(found) == spec


@pytest.mark.parametrize("sigma", [None, 2e-12], ids=["division", "division2"])
def test_a_second_parameter_that_is_nothing_is_a_second_one(sigma: float | None) -> None:
    uncertainty = Uncertainty(1e-9, (0.1, 0.1), sigma)
    found = loads(dumps(replace(recorded(CalibrationSpec()), uncertainty=uncertainty)))
    assert isinstance(found, Calibration)
    assert spec_of(found).model == ("division" if sigma is None else "division2")


def test_what_is_as_by_default_is_not_written() -> None:
    assert "options" not in dumps(recorded(CalibrationSpec()))
    spec = CalibrationSpec(center="image", sobel=21)
    assert options_of(spec, recorded(spec)) == {"center": "image"}
    two = CalibrationSpec(model="division2")
    assert options_of(two, recorded(two)) == {}


def test_a_second_parameter_that_was_not_told_is_asked_for_again() -> None:
    spec = CalibrationSpec(model="division2")
    one = recorded(CalibrationSpec())
    assert options_of(spec, one) == {"model": "division2"}
    text = dumps(replace(one, source=Source(options=options_of(spec, one))))
    assert 'options = { model = "division2" }' in text
    found = loads(text)
    assert isinstance(found, Calibration)
    assert found.model.lam2 == 0
    assert spec_of(found) == replace(spec, pixel_aspect=1.0)


def test_every_option_is_kept_somewhere() -> None:
    assert {f.name for f in fields(CalibrationSpec)} == {*ELSEWHERE, *RECORDED}
    assert set(UNUSUAL) == set(RECORDED)


def test_options_that_make_no_sense_are_refused() -> None:
    source = Source(options={"samples": 1})
    with pytest.raises(UsageError, match="samples"):
        spec_of(Calibration(DivisionModel(-1e-6, (360.0, 270.0), (720, 540)), source=source))
