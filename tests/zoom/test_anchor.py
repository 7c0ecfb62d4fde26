"""What steps add up to, held to the zoom since a key picture."""

from __future__ import annotations

import math
from dataclasses import replace

import cv2
import numpy as np
import pytest

from endocal.zoom.anchor import Anchor, AnchorSpec, Correction
from endocal.zoom.parallax import ScaleStep
from endocal.zoom.planar import PlanarFit, PlanarMotion
from endocal.zoom.table import Setting, ZoomTable

from . import scenery

TABLE = ZoomTable(
    tuple(Setting(scenery.STRENGTH / d**2, scenery.MIDDLE, d) for d in (300.0, 1500.0)),
    scenery.SIZE,
)
NONE = (0.0, 0.0)
INTERVAL = AnchorSpec().interval
STEP = ScaleStep(0.0, 0.01, 0.0, np.eye(2), np.zeros(2), np.zeros(2), lasting=0.0)


def begun(variance: float) -> Anchor:
    """An anchor whose key is the scene's first picture, before steps that gathered a variance."""
    anchor = Anchor()
    anchor.begin(scenery.picture(), TABLE, scenery.DIAMETER, NONE)
    anchor.doubt(variance)
    return anchor


def take(
    anchor: Anchor,
    zoom: float,
    told: float,
    step: ScaleStep = STEP,
    seed: int = 1,
    slow: float = 0.0,
) -> Correction:
    """Go on by an interval to a picture zoomed by a logarithm since the key, taken to be ``told``."""
    picture = scenery.picture(zoom=zoom, seed=seed)
    diameter = scenery.DIAMETER * math.exp(told)
    return anchor.take(picture, TABLE, diameter, NONE, step, INTERVAL, slow)


def test_steps_that_are_too_small_are_made_up_for() -> None:
    more = take(begun(0.03**2), 0.1, 0.08, STEP._replace(logarithm=0.08))
    assert more.logarithm == pytest.approx(0.02, abs=0.004)
    # Not surer than a match.
    assert 0.03**2 - more.variance > 0
    assert math.sqrt(0.03**2 - more.variance) > AnchorSpec().least / 2


def test_what_is_known_well_is_left_as_it_is() -> None:
    more = take(begun(1e-5**2), 0.1, 0.08, STEP._replace(logarithm=0.08))
    assert abs(more.logarithm) < 1e-4


def test_matching_again_counts_once() -> None:
    anchor, variance = begun(0.03**2), 0.03**2
    told, taken, left = 0.08, [], []
    for seed in range(1, 9):
        more = take(anchor, 0.1, told, STEP._replace(logarithm=0.08 if seed == 1 else 0.0), seed)
        told += more.logarithm
        variance -= more.variance
        taken.append(told)
        left.append(variance)
    assert taken == pytest.approx([0.1] * 8, abs=0.005)
    # Eight matches are no surer than the surest of them.
    assert left == pytest.approx([left[0]] * 8, rel=0.3)


def test_a_match_waits_for_its_interval() -> None:
    anchor = begun(0.03**2)
    picture = scenery.picture(zoom=0.1)
    diameter = scenery.DIAMETER * math.exp(0.08)
    step = STEP._replace(logarithm=0.08)
    assert anchor.take(picture, TABLE, diameter, NONE, step, INTERVAL / 4, 0.0) == Correction()


def test_before_a_curved_scene_that_a_hand_goes_along_the_steps_decide() -> None:
    step = STEP._replace(curved=1.0, aside=np.array([0.3, 0.0]))
    aside = float(step.aside[0]) * scenery.FOCAL
    anchor = begun(0.01**2)
    generator = np.zeros((3, 3))
    generator[0, 2] = aside
    step = step._replace(logarithm=0.03, generator=generator)
    picture = scenery.picture(scenery.moved((aside, 0.0)), 0.05, seed=1)
    diameter = scenery.DIAMETER * math.exp(0.03)
    more = anchor.take(picture, TABLE, diameter, NONE, step, INTERVAL, 0.0)
    assert abs(more.logarithm) < 0.002


def test_before_a_rough_scene_whose_errors_last_the_steps_decide() -> None:
    step = STEP._replace(logarithm=0.08, lasting=1.0)
    assert abs(take(begun(0.03**2), 0.1, 0.08, step).logarithm) < 1e-4


def test_a_key_that_is_seen_much_larger_gives_way_to_another() -> None:
    anchor = begun(0.03**2)
    told = 0.0
    # Each interval by 15 %, and told a tenth too small.
    for i in range(1, 7):
        told += 0.135
        told += take(anchor, 0.15 * i, told, STEP._replace(logarithm=0.135), i).logarithm
        anchor.doubt(0.02**2)
    # Of what is seen 2.5 times larger the first key tells nothing.
    assert told == pytest.approx(0.9, abs=0.02)


def test_another_scene_makes_a_new_key() -> None:
    anchor = begun(0.03**2)
    other = scenery.picture(scene=scenery.OTHER_SCENE)
    assert anchor.take(other, TABLE, scenery.DIAMETER, NONE, STEP, INTERVAL, 0.0) == Correction()
    anchor.doubt(0.03**2)
    other = scenery.picture(zoom=0.1, scene=scenery.OTHER_SCENE, seed=2)
    step = STEP._replace(logarithm=0.08)
    more = anchor.take(other, TABLE, scenery.DIAMETER * math.exp(0.08), NONE, step, INTERVAL, 0.0)
    assert more.logarithm == pytest.approx(0.02, abs=0.005)


def test_the_spec_says_how_often() -> None:
    anchor = Anchor(replace(AnchorSpec(), interval=0.0))
    anchor.begin(scenery.picture(), TABLE, scenery.DIAMETER, NONE)
    anchor.doubt(0.03**2)
    diameter = scenery.DIAMETER * math.exp(0.08)
    step = STEP._replace(logarithm=0.08)
    more = anchor.take(scenery.picture(zoom=0.1), TABLE, diameter, NONE, step, 0.04, 0.0)
    assert more.logarithm == pytest.approx(0.02, abs=0.004)


def halved(image: np.ndarray) -> np.ndarray:
    """The picture reduced twice, as the tracker reduces large ones."""
    return cv2.resize(image, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)


def test_a_reduced_picture_tells_as_well() -> None:
    anchor = Anchor()
    anchor.begin(halved(scenery.picture()), TABLE, scenery.DIAMETER, NONE)
    anchor.doubt(0.03**2)
    step = STEP._replace(logarithm=0.08)
    diameter = scenery.DIAMETER * math.exp(0.08)
    picture = halved(scenery.picture(zoom=0.1, seed=1))
    more = anchor.take(picture, TABLE, diameter, NONE, step, INTERVAL, 0.0)
    assert more.logarithm == pytest.approx(0.02, abs=0.005)


def test_slow_zooms_count_as_doubt_of_the_sum() -> None:
    more = take(begun(0.0), 0.1, 0.08, STEP._replace(logarithm=0.08), slow=0.03**2)
    assert more.logarithm == pytest.approx(0.02, abs=0.004)


def test_errors_that_match_and_steps_share_leave_the_steps_more() -> None:
    anchor, step = Anchor(), STEP._replace(logarithm=0.08)
    own, shared = (
        anchor._weigh(PlanarFit(PlanarMotion(logarithm=0.1), 0.01, part), step, 0.08, 0.02**2, 0.0)
        for part in (0.0, 1.0)
    )
    assert own.logarithm == pytest.approx(0.02 * 0.02**2 / (0.02**2 + 0.01**2 + 0.0015**2))
    assert shared.logarithm < 0.85 * own.logarithm
    assert shared.variance < 0.7 * own.variance


@pytest.mark.parametrize(("aside", "far"), [((0.3, 0.0), False), ((0.0, 0.0), True)])
def test_a_curved_scene_deceives_only_where_hand_and_picture_went_aside(
    aside: tuple[float, float], far: bool
) -> None:
    # Either alone: a hand that turns moves the picture, and steps may say aside of a picture that stays.
    generator = np.zeros((3, 3))
    generator[0, 2] = 0.3 * scenery.FOCAL * far
    moved = scenery.moved((0.3 * scenery.FOCAL, 0.0)) if far else None
    step = STEP._replace(logarithm=0.08, curved=1.0, aside=np.array(aside), generator=generator)
    picture = scenery.picture(moved, 0.1, seed=1)
    diameter = scenery.DIAMETER * math.exp(0.08)
    more = begun(0.03**2).take(picture, TABLE, diameter, NONE, step, INTERVAL, 0.0)
    assert more.logarithm == pytest.approx(0.02, abs=0.005)


def test_a_new_key_begins_where_the_last_match_left_off() -> None:
    anchor, told = begun(0.03**2), 0.0
    # Past 1.5 times the first key gives way; its last correction counts for the new one as well.
    told += 0.4 + take(anchor, 0.45, 0.4, STEP._replace(logarithm=0.4)).logarithm
    assert told == pytest.approx(0.45, abs=0.005)
    # The new key has gathered no doubt as yet, so that a match changes nothing.
    step = STEP._replace(logarithm=0.0)
    assert take(anchor, 0.45, told, step, seed=2).logarithm == pytest.approx(0.0, abs=1e-6)
    anchor.doubt(0.03**2)
    assert take(anchor, 0.45, told, step, seed=3).logarithm == pytest.approx(0.0, abs=0.003)


def test_a_key_that_is_forgotten_tells_nothing() -> None:
    anchor = begun(0.03**2)
    anchor.forget()
    assert take(anchor, 0.1, 0.08, STEP._replace(logarithm=0.08)) == Correction()


def test_a_centre_that_moves_with_the_zoom_is_followed() -> None:
    # The lens's own centre stays; the table's goes by 200 px per unit of the logarithm, as the picture does.
    def middle(diameter: float) -> tuple[float, float]:
        return scenery.MIDDLE[0] + 200 * math.log(diameter / scenery.DIAMETER), scenery.MIDDLE[1]

    table = ZoomTable(
        tuple(
            Setting(scenery.STRENGTH / d**2, middle(d), d)
            for d in scenery.DIAMETER * np.exp(np.linspace(-0.2, 0.4, 25))
        ),
        scenery.SIZE,
    )
    anchor = begun(0.03**2)
    picture = scenery.picture(zoom=0.15, seed=1)
    along = np.array([[1.0, 0.0, 200 * 0.15], [0.0, 1.0, 0.0]])
    picture = cv2.warpAffine(picture, along, scenery.SIZE, borderMode=cv2.BORDER_REPLICATE)
    step = STEP._replace(logarithm=0.05)
    diameter = scenery.DIAMETER * math.exp(0.05)
    more = anchor.take(picture, table, diameter, NONE, step, INTERVAL, 0.0)
    assert more.logarithm == pytest.approx(0.1, abs=0.005)


def test_a_new_key_forgets_how_far_the_hand_went() -> None:
    aside = 0.3 * scenery.FOCAL
    generator = np.zeros((3, 3))
    generator[0, 2] = aside
    went = STEP._replace(curved=1.0, aside=np.array([0.3, 0.0]), generator=generator)
    anchor = begun(0.03**2)
    picture = scenery.picture(scenery.moved((aside, 0.0)), seed=1)
    anchor.take(picture, TABLE, scenery.DIAMETER, NONE, went, INTERVAL, 0.0)
    anchor.begin(scenery.picture(), TABLE, scenery.DIAMETER, NONE)
    anchor.doubt(0.03**2)
    step = STEP._replace(logarithm=0.08, curved=1.0)
    assert take(anchor, 0.1, 0.08, step).logarithm == pytest.approx(0.02, abs=0.004)
