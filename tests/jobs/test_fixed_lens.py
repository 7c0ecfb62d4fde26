"""One calibration for all frames: what the frames' circle tells of its zoom and its place."""

from __future__ import annotations

import numpy as np
import pytest

from endocal.boundary.detect import boundary_of
from endocal.calibration.result import Calibration
from endocal.errors import InputError
from endocal.jobs.fixed_lens import FixedModel
from endocal.model import DivisionModel
from endocal.synth.camera import ContentCircle

SIZE = (640, 480)
CIRCLE = (322.0, 237.0)
MODEL = DivisionModel(-6e-6, (330.0, 231.0), SIZE)
CALIBRATION = Calibration(MODEL, boundary=boundary_of(CIRCLE, 400.0, SIZE))


def frame(x: float = 0.0, y: float = 0.0, diameter: float = 400.0, seed: int = 0) -> np.ndarray:
    """Noisy grey tissue in a circle that lies (x, y) px from the calibration's."""
    circle = ContentCircle((CIRCLE[0] + x, CIRCLE[1] + y), diameter, 2.0)
    noise = np.random.default_rng(seed).normal(0, 2, SIZE[::-1])
    return np.clip(np.rint(6 + 120 * circle.transmission(SIZE) + noise), 0, 255).astype(np.uint8)


def watch(lens: FixedModel, frames: list[np.ndarray]) -> list[DivisionModel]:
    return [lens.model(lambda luma=luma: luma, i / 25) for i, luma in enumerate(frames)]


def test_the_model_stays_and_nothing_is_said_where_the_circle_is_the_same() -> None:
    lens = FixedModel(CALIBRATION)
    models = watch(lens, [frame(seed=i) for i in range(3)])
    assert all(m is MODEL for m in models)
    assert lens.notes == []


def test_another_zoom_is_told_once() -> None:
    lens = FixedModel(CALIBRATION)
    models = watch(lens, [frame(diameter=440.0)] * 102)
    assert all(m is MODEL for m in models)
    (note,) = lens.notes
    assert "440 px wide at 0.00 s, where it was 400 px" in note
    assert "lambda 21% too strong" in note


def test_a_circle_elsewhere_is_told() -> None:
    lens = FixedModel(CALIBRATION)
    watch(lens, [frame(6.0, -8.0)])
    (note,) = lens.notes
    assert "lies 10 px from where it was in the calibration, at 0.00 s: --center follow" in note


def test_the_centre_follows_the_circle_if_it_is_to() -> None:
    lens = FixedModel(CALIBRATION, "follow")
    places = [(0.0, 0.0)] * 3 + [(0.4 * i, -0.3 * i) for i in range(30)]
    models = watch(lens, [frame(x, y, seed=i) for i, (x, y) in enumerate(places)])
    for i, (model, (x, y)) in enumerate(zip(models, places, strict=True)):
        # Where the circle sets off at full speed, three measurements have to agree.
        late = 1.5 if 3 < i < 7 else 0.0
        assert model.center == pytest.approx((330.0 + x, 231.0 + y), abs=0.35 + late)
        assert model.lam == MODEL.lam
    assert lens.notes == []


def test_where_no_circle_is_known_nothing_is_looked_at() -> None:
    def never() -> np.ndarray:
        raise AssertionError

    bare = Calibration(MODEL)
    assert FixedModel(bare).model(never, None) is MODEL
    with pytest.raises(InputError, match="does not tell where its visible circle was"):
        FixedModel(bare, "follow")
