"""The zoom between two pictures of a plane, whose homography and zoom are known exactly."""

from __future__ import annotations

import math

import numpy as np
import pytest

from endocal.zoom.likeness import Likeness
from endocal.zoom.planar import PlanarFit, PlanarMotion, PlanarSpec, fit_planar
from tests.zoom.scenery import SIZE, STRENGTH, moved, seen, turned, view

# How well the homography and the zoom are known before.
OFF = moved((0.01, -0.01), 0.01, 0.01, (0.01, 0.0))
ZOOM_OFF = 0.03
SWAY = moved((0.05, -0.03), 0.1, 0.04, (0.05, -0.05))


def fitted(
    homography: np.ndarray,
    zoom: float,
    seed: int,
    noise: float = 0.05,
    strength: float = STRENGTH,
    wrong: float = 0.0,
    shared: float = 0.0,
    likeness: Likeness | None = None,
    hand: float = 0.1,
) -> PlanarFit:
    """Fit 150 places with so much noise, px, besides what patches share; a part is ``wrong``, up to 15 px."""
    rng = np.random.default_rng(seed)
    places = rng.uniform((5, 5), (475, 355), (150, 2))
    start = view(strength=strength).undistorted(places)
    after = seen(start, homography, zoom, strength)
    inside = ((after > 0) & (after < SIZE)).all(axis=1)
    start, after = start[inside], after[inside]
    patch = (after // (120, 120)).astype(int) @ (1, 4)
    after += rng.normal(0, noise, after.shape) + rng.normal(0, shared, (12, 2))[patch]
    lost = rng.random(len(after)) < wrong
    after[lost] += rng.uniform(-15, 15, (int(lost.sum()), 2))
    known = homography @ OFF
    later = view(view().diameter * math.exp(zoom - ZOOM_OFF), strength)
    return fit_planar(
        start,
        after.astype(np.float32),
        later,
        (0.0, 0.0),
        PlanarMotion(known / known[2, 2], zoom - ZOOM_OFF),
        hand,
        0.05,
        likeness or Likeness(6.0),
    )


@pytest.mark.parametrize(
    ("homography", "zoom"),
    [
        (SWAY, 0.1),
        (SWAY, math.log(1.5)),
        (turned((20.0, 0.0, 0.0)), 0.0),
        (turned((14.0, -14.0, 5.0)), -0.2),
    ],
    ids=["sway", "1.5 times", "turned 20 degrees", "turned and zoomed out"],
)
def test_the_zoom_is_known_as_well_as_is_stated(homography: np.ndarray, zoom: float) -> None:
    fits = [fitted(homography, zoom, seed) for seed in range(40)]
    z = np.array([(f.motion.logarithm - zoom) / f.sigma for f in fits])
    assert 0.7 < math.sqrt(np.mean(z**2)) < 1.4
    # A twentieth of a px over half a picture's height, most of which the homography takes: under 0.1 %.
    assert np.median([f.sigma for f in fits]) < 1e-3


def test_a_fifth_of_places_that_go_their_own_ways_is_left_out() -> None:
    fits = [fitted(SWAY, 0.1, seed, wrong=0.2) for seed in range(40)]
    z = [(f.motion.logarithm - 0.1) / f.sigma for f in fits]
    # The median of all lengths, wrong ones too, states the rest's scatter a good third too large.
    assert 0.5 < math.sqrt(np.mean(np.square(z))) < 1.4
    assert np.median([f.sigma for f in fits]) < 1e-3


def test_more_noise_than_expected_is_seen_and_stated() -> None:
    fits = [fitted(SWAY, 0.1, seed, noise=0.3) for seed in range(40)]
    z = [(f.motion.logarithm - 0.1) / f.sigma for f in fits]
    assert 0.7 < math.sqrt(np.mean(np.square(z))) < 1.4
    assert fits[0].sigma > 3 * fitted(SWAY, 0.1, 0).sigma


def test_the_homography_is_found_with_the_zoom() -> None:
    motion = fitted(SWAY, 0.1, 1, noise=0.01).motion
    scene = view().undistorted(np.array([[60.0, 60.0], [420.0, 90.0], [250.0, 300.0]]))
    assert seen(scene, motion.homography, motion.logarithm) == pytest.approx(
        seen(scene, SWAY, 0.1), abs=0.05
    )
    assert motion.back(motion.forth(scene)) == pytest.approx(scene, abs=1e-12)
    assert motion.aside == pytest.approx(math.hypot(0.05, 0.03), abs=1e-3)
    still = PlanarMotion(moved(nearer=0.2), 0.1)
    assert still.scale == pytest.approx(math.exp(0.3))


def test_a_weak_lens_states_that_it_tells_little() -> None:
    strong, weak = (fitted(SWAY, 0.1, 1, strength=s) for s in (STRENGTH, STRENGTH / 20))
    assert weak.sigma > 10 * strong.sigma
    # Without distortion nothing but what was expected before tells a zoom from an approach.
    none = fitted(SWAY, 0.1, 1, strength=0.0, hand=0.1)
    assert none.sigma == pytest.approx(1 / math.hypot(1 / 0.1, 1 / 0.2), rel=0.02)


def test_an_approach_that_no_hand_makes_is_taken_for_a_zoom_by_a_weak_lens() -> None:
    steady = fitted(moved(nearer=0.03), 0.0, 1, strength=0.0, hand=1e-4).motion
    assert steady.logarithm == pytest.approx(0.03, abs=1e-3)
    assert steady.approach == pytest.approx(0.0, abs=1e-3)


def test_residuals_alike_among_neighbours_count_less() -> None:
    fits = []
    for noise, shared in ((0.5, 0.0), (0.05, 0.5)):
        likeness = Likeness(6.0)
        fits.append(
            [
                fitted(SWAY, 0.1, seed, noise, shared=shared, likeness=likeness)
                for seed in range(12)
            ][-1]
        )
    own, alike = fits
    assert own.shared < 0.3
    assert alike.shared == 1.0
    assert alike.sigma > 2 * own.sigma


def test_residuals_alike_are_stated_as_large_as_they_scatter() -> None:
    likeness = Likeness(6.0)
    fits = [fitted(SWAY, 0.1, seed, shared=0.5, likeness=likeness) for seed in range(60)][5:]
    z = [(f.motion.logarithm - 0.1) / f.sigma for f in fits]
    assert 0.5 < math.sqrt(np.mean(np.square(z))) < 1.4


def test_a_centre_that_moves_with_the_zoom_is_reckoned_with() -> None:
    drift, zoom = (60.0, -40.0), 0.1
    places = np.random.default_rng(2).uniform((30, 30), (450, 330), (150, 2))
    start = view().undistorted(places)
    after = seen(start, np.eye(3), zoom) + np.multiply(drift, zoom)
    # The later view has the centre of the zoom that is taken to be, which is none.
    fit = fit_planar(
        start,
        after.astype(np.float32),
        view(),
        drift,
        PlanarMotion(),
        0.1,
        0.05,
        Likeness(6.0),
    )
    assert fit.motion.logarithm == pytest.approx(zoom, abs=1e-3)
    assert fit.motion.homography == pytest.approx(np.eye(3), abs=3e-3)


def test_steps_add_up_to_the_motion_of_all() -> None:
    """A flow that counts about halfway makes of many small turns the large one."""
    once = turned((0.5, 0.2, 0.3))
    # The logarithm of a small homography, as Cayley's transform has it.
    generator = 2 * np.linalg.solve(once + np.eye(3), once - np.eye(3))
    motion = PlanarMotion()
    for _ in range(40):
        motion = motion.then(generator, 0.01)
    assert motion.homography == pytest.approx(turned((20.0, 8.0, 12.0)), abs=1e-9)
    assert motion.logarithm == pytest.approx(0.4)


def test_without_distortion_what_is_expected_of_zoom_and_hand_shares_a_dilation() -> None:
    fit = fitted(np.eye(3), 0.1, 1, strength=-1e-6, hand=PlanarSpec().zoom)
    # As much of either: the half of what the zoom is off by passes for approach.
    assert fit.motion.logarithm == pytest.approx(0.1 - ZOOM_OFF / 2, abs=0.1 * abs(ZOOM_OFF))
    assert fit.motion.approach == pytest.approx(ZOOM_OFF / 2, abs=0.1 * abs(ZOOM_OFF))


def test_a_centre_that_drifts_with_the_zoom_is_taken_along() -> None:
    places = np.random.default_rng(1).uniform((5, 5), (475, 355), (150, 2))
    drift = np.array([40.0, -20.0])
    # The view is the one before the zoom: all of it is to be found, and the centre's way with it.
    after = seen(view().undistorted(places), np.eye(3), 0.1) + 0.1 * drift
    fit = fit_planar(
        view().undistorted(places),
        after.astype(np.float32),
        view(),
        (40.0, -20.0),
        PlanarMotion(),
        0.01,
        0.05,
        Likeness(6.0),
    )
    assert fit.motion.logarithm == pytest.approx(0.1, abs=1e-3)
    assert fit.motion.aside < 1e-3
