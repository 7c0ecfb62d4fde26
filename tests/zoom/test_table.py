"""The zoom table: the article's Table I, the law, the look-ups and what is refused."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from endocal.boundary.detect import boundary_of
from endocal.errors import InputError
from endocal.zoom.table import LOOKUPS, Setting, ZoomTable

SIZE = (720, 540)
MIDDLE = (359.5, 269.5)

# Table I: lambda in px^-2 and diameter in px of the two settings of each of two endoscopes, and what the
# article predicts each from the other. The ~712 px that it prints for F4 do not give its own predictions:
# 432 px times their common ratio of 1.8378 does.
TABLE_I = {
    "F1": (-2.9644e-5, 210.0, -2.8126e-5),
    "F2": (-1.2742e-5, 312.0, -1.3430e-5),
    "F3": (-7.5446e-6, 432.0, -5.6195e-6),
    "F4": (-1.6638e-6, 432.0 * 1.8378, -2.2338e-6),
}


def table(*settings: tuple[float, float]) -> ZoomTable:
    """A table from (lambda, diameter) pairs."""
    return ZoomTable(tuple(Setting(lam, MIDDLE, d) for lam, d in settings), SIZE)


def lens(strength: float, diameters: list[float], noise: list[float] | None = None) -> ZoomTable:
    """A table of a lens that obeys the law, to within ``noise``."""
    noise = noise or [0.0] * len(diameters)
    settings = []
    for d, n in zip(diameters, noise, strict=True):
        area = boundary_of(MIDDLE, d, SIZE).area
        settings.append(Setting(strength * (1 + n) / d**2, MIDDLE, d, area))
    return ZoomTable(tuple(settings), SIZE)


@pytest.mark.parametrize(
    ("known", "asked"), [("F1", "F2"), ("F2", "F1"), ("F3", "F4"), ("F4", "F3")]
)
def test_table_one_of_the_article(known: str, asked: str) -> None:
    lam, diameter, _ = TABLE_I[known]
    _, other, printed = TABLE_I[asked]
    # One setting beside it, far away, so that the known one is the closest: the prediction is from it alone.
    far = diameter * (0.1 if other > diameter else 10)
    both = table((lam, diameter), (lam * (diameter / far) ** 2, far))
    predicted = both.at_diameter(other, "diameter").lam
    assert f"{predicted:.4e}" == f"{printed:.4e}"


def test_the_law_names_the_constant_and_the_outlier() -> None:
    law = lens(-1.3, [400, 500, 600, 700], [0.0, 0.01, 0.12, -0.01]).law
    # The median, between 0 and 1 %.
    assert law.lambda_diameter2 == pytest.approx(-1.3 * 1.005)
    assert law.outlier == 2
    assert law.departures[2] == pytest.approx(1.12 / 1.005 - 1)
    assert law.spread == pytest.approx(np.sqrt(np.mean(np.square(law.departures))))


def test_two_settings_cannot_tell_which_of_them_is_wrong() -> None:
    assert lens(-1.3, [400, 600], [0.0, 0.15]).law.outlier is None


def test_a_pair_is_judged_by_its_ratio() -> None:
    # Within 30 % of their mean, but not of each other; the article's F3 and F4 are one lens.
    with pytest.raises(InputError, match=r"broken by 31% at diameter 400 px and 600 px"):
        lens(-1.3, [400, 600], [0.0, -0.31])
    with pytest.raises(InputError, match=r"broken by 46%"):
        lens(-1.3, [400, 600], [0.0, -0.46])
    lens(-1.3, [400, 600], [-0.29, 0.0])
    (third, wide, _), (fourth, tele, _) = TABLE_I["F3"], TABLE_I["F4"]
    assert len(table((third, wide), (fourth, tele)).settings) == 2


def test_settings_that_agree_have_no_outlier() -> None:
    assert lens(-1.3, [400, 500, 600], [0.0, 0.01, -0.01]).law.outlier is None


def test_the_order_of_the_settings_does_not_matter() -> None:
    settings = lens(-1.3, [400, 500, 650], [0, 0.02, -0.01]).settings
    tables = [ZoomTable(p, SIZE) for p in itertools.permutations(settings)]
    assert all(t == tables[0] for t in tables)


@given(
    strength=st.floats(-2.5, 0.5).filter(lambda k: abs(k) > 0.05),
    diameters=st.lists(st.floats(150, 900), min_size=2, max_size=5),
    at=st.floats(100, 1500),
    lookup=st.sampled_from(["auto", "diameter"]),
)
def test_a_lens_that_obeys_the_law_is_predicted_at_any_diameter(
    strength: float, diameters: list[float], at: float, lookup: str
) -> None:
    assume(all(b / a > 1.01 for a, b in itertools.pairwise(sorted(diameters))))
    model = lens(strength, diameters).at_diameter(at, lookup)
    assert model.lam * at**2 == pytest.approx(strength, rel=1e-9)


@settings(max_examples=30)
@given(noise=st.lists(st.floats(-0.1, 0.1), min_size=3, max_size=3))
def test_auto_is_exact_at_the_settings_and_smooth_between(noise: list[float]) -> None:
    zoom = lens(-1.3, [400, 520, 700], noise)
    for setting in zoom.settings:
        assert zoom.at_diameter(setting.diameter).lam == pytest.approx(setting.lam, rel=1e-12)
    d = np.linspace(350, 800, 1801)
    strength = np.array([zoom.at_diameter(float(v)).lam * v**2 for v in d])
    slope = np.diff(strength) / np.diff(d)
    # No step in the value and none in the slope, at the settings or elsewhere; the steepest possible piece
    # goes over 0.26 within 120 px, and its slope changes by less than a ten-thousandth per sample.
    assert np.abs(np.diff(slope)).max() < 1e-4
    low, high = min(strength), max(strength)
    values = [s.strength for s in zoom.settings]
    assert low >= min(values) - 1e-12
    assert high <= max(values) + 1e-12


def test_auto_is_no_worse_than_the_articles_look_ups_on_settings_held_out() -> None:
    # Lenses whose lambda D^2 drifts with the zoom and whose calibrations have errors, each setting left
    # out in turn.
    rng = np.random.default_rng(0)
    errors: dict[str, list[float]] = {name: [] for name in LOOKUPS}
    for _ in range(200):
        diameters = np.sort(rng.uniform(300, 620, 4))
        if np.diff(diameters).min() < 25:
            continue
        drift, errs = rng.normal(0, 0.05), rng.normal(0, 0.01, 4)
        noise = drift * (diameters - 450) / 150 + errs
        full = lens(-1.3, list(diameters), list(noise))
        for i in range(4):
            rest = ZoomTable(full.settings[:i] + full.settings[i + 1 :], SIZE)
            out = full.settings[i]
            boundary = boundary_of(MIDDLE, out.diameter, SIZE)
            for name in LOOKUPS:
                errors[name].append(rest.at(boundary, name).lam / out.lam - 1)
    rms = {name: float(np.sqrt(np.mean(np.square(e)))) for name, e in errors.items()}
    assert rms["auto"] <= min(rms["diameter"], rms["area"])


def test_area_interpolates_linearly_between_the_two_areas() -> None:
    zoom = lens(-1.3, [500, 560, 640])
    a, b = zoom.settings[1:]
    assert a.area is not None
    assert b.area is not None
    boundary = boundary_of(MIDDLE, 600, SIZE)
    t = (boundary.area - a.area) / (b.area - a.area)
    assert zoom.at(boundary, "area").lam == pytest.approx(a.lam + t * (b.lam - a.lam))


def test_area_outside_the_settings_falls_back_on_the_law() -> None:
    zoom = lens(-1.3, [300, 400])
    boundary = boundary_of(MIDDLE, 480, SIZE)
    assert zoom.at(boundary, "area").lam == pytest.approx(-1.3 / 480**2)


def test_area_needs_an_area_in_every_setting() -> None:
    with pytest.raises(InputError, match="area"):
        table((-1e-5, 300), (-5.6e-6, 400)).at(boundary_of(MIDDLE, 350, SIZE), "area")


def test_the_centre_goes_along_a_line_between_neighbours() -> None:
    settings = tuple(
        Setting(-1.3 / d**2, (300 + 0.1 * d, 280 - 0.05 * d), d) for d in (400.0, 500.0, 650.0)
    )
    zoom = ZoomTable(settings, SIZE)
    for d in (350.0, 450.0, 600.0, 800.0):
        center = zoom.at_diameter(d).center
        assert center == pytest.approx((300 + 0.1 * d, 280 - 0.05 * d))


def test_lam2_scales_with_the_fourth_power() -> None:
    settings = tuple(
        Setting(-0.9 / d**2, MIDDLE, d, lam2=-0.8 / d**4) for d in (400.0, 500.0, 650.0)
    )
    model = ZoomTable(settings, SIZE).at_diameter(560)
    assert model.lam2 == pytest.approx(-0.8 / 560**4)
    assert ZoomTable(settings, SIZE).law.spread == pytest.approx(0, abs=1e-12)


@given(scale=st.floats(0.3, 4), at=st.floats(200, 900))
def test_rescaling_is_looking_up_in_the_other_frame(scale: float, at: float) -> None:
    size = (round(SIZE[0] * scale), round(SIZE[1] * scale))
    factor = size[1] / SIZE[1]
    zoom = lens(-1.3, [400, 500, 650], [0, 0.03, -0.02])
    there = zoom.rescale(size).at_diameter(at * factor)
    here = zoom.at_diameter(at).rescale(size)
    assert there.lam == pytest.approx(here.lam, rel=1e-9)
    assert there.center == pytest.approx(here.center, abs=1e-6)


def test_the_circle_is_looked_up_and_rescaled_as_the_centre_is() -> None:
    settings = tuple(
        Setting(-1.3 / d**2, (300 + 0.1 * d, 200.0), d, circle=(300 + 0.1 * d, 200.0))
        for d in (400.0, 500.0, 650.0)
    )
    for zoom in (ZoomTable(settings, SIZE), ZoomTable(settings, SIZE).rescale((1440, 1080))):
        for diameter in (300.0, 480.0, 900.0):
            circle = zoom.circle_at(diameter)
            assert circle == pytest.approx(zoom.at_diameter(diameter).center)


def test_a_table_says_what_it_covers() -> None:
    zoom = lens(-1.3, [400, 650])
    assert zoom.covers(400)
    assert zoom.covers(500)
    assert zoom.covers(393)
    assert not zoom.covers(390)
    assert zoom.covers(662)
    assert not zoom.covers(665)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ([(-1e-5, 300)], "2 settings"),
        ([], "2 settings"),
        ([(-1e-5, 300), (-1e-5, 300)], "same diameter"),
        ([(-1.3 / 300**2, 300), (-2.6 / 400**2, 400)], "law"),
        ([(-1.3 / 300**2, 300), (-1.3 / 400**2, 400), (-2.0 / 500**2, 500)], "at diameter 500 px"),
        ([(-1.3 / 300**2, 300), (1.3 / 400**2, 400)], "law"),
        ([(-4.1 / 300**2, 300), (-4.1 / 400**2, 400)], "folds"),
    ],
)
def test_settings_that_are_no_table_are_refused(
    settings: list[tuple[float, float]], words: str
) -> None:
    with pytest.raises(InputError, match=words):
        table(*settings)


@pytest.mark.parametrize("value", [float("nan"), float("inf"), 0.0, -5.0])
def test_a_setting_needs_a_diameter(value: float) -> None:
    with pytest.raises(InputError, match="diameter"):
        Setting(-1e-6, MIDDLE, value)
    with pytest.raises(InputError, match="diameter"):
        lens(-1.3, [300, 400]).at_diameter(value)


def test_another_shape_of_frame_is_refused() -> None:
    with pytest.raises(InputError, match="aspect"):
        lens(-1.3, [300, 400]).rescale((1280, 720))


def test_a_diameter_alone_is_looked_up_by_area_as_by_diameter() -> None:
    # Far from the law, so that the look-ups differ.
    table = ZoomTable(
        (Setting(-5e-6, MIDDLE, 400.0, 1e5), Setting(-4e-6, MIDDLE, 500.0, 2e5)), SIZE
    )
    assert table.at_diameter(460, "area") == table.at_diameter(460, "diameter")
    assert table.at_diameter(460, "area") != table.at_diameter(460, "auto")


@pytest.mark.parametrize("circle", [(-721.0, 270.0), (1441.0, 270.0), (360.0, 1e9)])
def test_a_circle_far_outside_the_frame_is_refused_by_setting(circle: tuple[float, float]) -> None:
    settings = (
        Setting(-8e-6, MIDDLE, 400.0, circle=MIDDLE),
        Setting(-5e-6, MIDDLE, 500.0, circle=circle),
    )
    with pytest.raises(
        InputError, match=r"setting 500 px: its circle's centre .* far outside the 720x540"
    ):
        ZoomTable(settings, SIZE)


def test_the_area_look_up_names_the_setting_that_has_none() -> None:
    settings = (Setting(-8e-6, MIDDLE, 400.0, 1e5), Setting(-5e-6, MIDDLE, 500.0))
    with pytest.raises(InputError, match=r"--lookup area: .* setting 500 px has no area: give it"):
        ZoomTable(settings, SIZE).check_lookup("area")
