"""Clips against their truth: the zoom, the board, the tissue, the instruments."""

from __future__ import annotations

import warnings
from dataclasses import replace
from fractions import Fraction

import cv2
import numpy as np
import pytest

from endocal.errors import UsageError
from endocal.model import DivisionModel
from endocal.synth.board import BoardScene, true_corners
from endocal.synth.camera import Camera
from endocal.synth.clip import BoardStand, ClipFrame, ClipScene, clip_frames
from endocal.synth.lens import typical_lens
from endocal.synth.motion import EyeMotion, ZoomPath, zoom_path
from endocal.synth.objects import Instrument, MovingInstrument
from endocal.synth.pattern import Pattern
from endocal.synth.rays import pixel_rays
from endocal.synth.tissue import Eye, Tissue

LENS = typical_lens((320, 240))
CLEAN = Camera(blur=0.8, noise=0.0)


def frames_of(scene: ClipScene) -> list[ClipFrame]:
    return list(clip_frames(scene))


def at_zooms(*zooms: float, **changes: object) -> list[ClipFrame]:
    """One frame at each zoom, the eye at rest."""
    path = ZoomPath(tuple((float(i), z) for i, z in enumerate(zooms)))
    scene = ClipScene(LENS, path, len(zooms), Fraction(1), CLEAN, seed=4)
    return frames_of(replace(scene, **changes))


def test_zooming_magnifies_the_undistorted_scene_about_the_centre() -> None:
    wide, near = at_zooms(1.0, 1.6)
    y, x = np.indices((240, 320), dtype=float)
    points = np.stack([x, y], -1)
    flat = wide.model.undistort(points) - wide.model.center
    inside = np.linalg.norm(points - wide.circle.center, axis=-1) < 80

    def likeness(zoom: float) -> float:
        seen = near.model.distort(zoom * flat + near.model.center).astype(np.float32)
        moved = cv2.remap(near.image, seen[..., 0], seen[..., 1], cv2.INTER_LINEAR)
        return float(np.corrcoef(moved[inside].ravel(), wide.image[inside].ravel())[0, 1])

    # The two differ by their pixels' blur; 1 % of zoom is half a pixel at the rim, which is seen.
    zooms = 1.6 * np.arange(0.95, 1.051, 0.01)
    assert np.argmax([likeness(z) for z in zooms]) == 5
    assert likeness(1.6) > 0.95


def test_the_law_holds_at_every_zoom() -> None:
    for frame in at_zooms(1.0, 1.3, 2.4):
        assert frame.model.lam * frame.circle.diameter**2 == pytest.approx(-1.3)
    c1, c2, c3 = (np.array(LENS.model_at(z).center) for z in (1.0, 1.5, 2.5))
    np.testing.assert_allclose((c3 - c1) / (c2 - c1), 3.0)


def test_the_board_is_seen_where_the_truth_puts_it() -> None:
    stand = BoardStand(Pattern(cols=7, rows=6, dark=0.05, light=0.8), square=0.2)
    motion = EyeMotion(sway=(0.05, 0.03, 0.02), turn=(2.0, 1.0, 3.0), period=4.0)
    frames = at_zooms(1.0, 1.3, 1.6, board=stand, motion=motion, seed=2)
    for frame in frames:
        focal = LENS.focal_at(frame.zoom)
        pose = stand.seen_by(frame.model, focal, motion.at(float(frame.time)))
        scene = BoardScene(frame.model, stand.pattern, pose, frame.circle)
        corners, seen = true_corners(scene)
        gray = cv2.cvtColor(frame.image, cv2.COLOR_BGR2GRAY)
        stop = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 50, 1e-3)
        start = corners[seen].astype(np.float32).reshape(-1, 1, 2).copy()
        found = cv2.cornerSubPix(gray, start, (3, 3), (-1, -1), stop).reshape(-1, 2)
        # Corners beside the vignetted, curved rim of a small picture are found to a tenth of a pixel.
        assert np.median(np.linalg.norm(found - corners[seen], axis=1)) < 0.1
        assert seen.sum() > 20


def test_a_frame_does_not_depend_on_the_ones_before_it() -> None:
    scene = ClipScene(LENS, ZoomPath(((0.0, 1.2),)), 3, camera=Camera(noise=4.0), seed=6)
    frames = frames_of(scene)
    assert [f.index for f in frames] == [0, 1, 2]
    assert [f.time for f in frames] == [Fraction(i, 25) for i in range(3)]
    # Nothing moves, so that only the noise differs, and its sigma is the stated one times sqrt 2.
    difference = frames[1].image.astype(float) - frames[0].image
    inside = np.hypot(*(np.indices((240, 320)) - np.array([[[120]], [[160]]]))) < 60
    assert difference[inside].std() == pytest.approx(4 * np.sqrt(2), rel=0.05)
    np.testing.assert_array_equal(frames_of(scene)[2].image, frames[2].image)


def test_instruments_move_and_hide_the_scene() -> None:
    shaft = Instrument((0.2, 0.1), 20.0, 0.15, radiance=0.0, shine=0.0)
    frames = at_zooms(1.0, 1.0001, instruments=(MovingInstrument(shaft, (0.2, 0.1), period=4.0),))
    bare = at_zooms(1.0, 1.0001)
    hidden = []
    for frame, plain in zip(frames, bare, strict=True):
        rays = pixel_rays(frame.model, LENS.focal_at(frame.zoom))
        covered = (
            MovingInstrument(shaft, (0.2, 0.1), 4.0).at(float(frame.time)).covers(rays.x, rays.y)
        )
        core = cv2.erode(covered.astype(np.uint8), np.ones((7, 7))) > 0
        assert frame.image[core].max() == 0
        apart = cv2.dilate(covered.astype(np.uint8), np.ones((11, 11))) == 0
        np.testing.assert_array_equal(frame.image[apart], plain.image[apart])
        hidden.append(covered)
    assert (hidden[0] != hidden[1]).sum() > 100


def test_going_nearer_is_not_zooming() -> None:
    """Camera motion moves what is near more than what is far: no scaling of the picture explains it."""
    rays = pixel_rays(DivisionModel(0.0, (159.5, 119.5), (320, 240)), 200.0)
    tissue = Tissue(3, texels=1024)
    before, after = (
        cv2.cvtColor(np.clip(255 * tissue.light(rays, Eye((0, 0, z))), 0, 255).astype(np.uint8), 6)
        for z in (0.0, 0.1)
    )
    flow = cv2.calcOpticalFlowFarneback(before, after, None, 0.5, 4, 25, 5, 7, 1.5, 0)
    y, x = np.indices(before.shape) - np.array([[[119.5]], [[159.5]]])
    r = np.hypot(x, y)
    outward = (flow[..., 0] * x + flow[..., 1] * y) / np.maximum(r, 1)
    ring = (r > 50) & (r < 110)
    scale = outward[ring] / r[ring]
    # On the whole things grow, by 0.1 / (distance - 0.1); the bowl's nearer parts grow more.
    assert 0.08 < np.median(scale) < 0.2
    assert np.percentile(scale, 90) - np.percentile(scale, 10) > 0.02


def test_tissue_is_lit_everywhere_and_bounded() -> None:
    rays = pixel_rays(LENS.model, LENS.focal)
    light = Tissue(1, texels=512).light(rays, Eye((0.05, -0.03, 0.1), 3, -2, 20))
    assert light.shape == (240, 320, 3)
    blind = np.isnan(rays.x)
    assert np.isfinite(light).all()
    assert (light[blind] == 0).all()
    assert (light[~blind] >= 0).all()
    assert 0.02 < np.median(light[~blind]) < 0.5


def test_rays_follow_the_model() -> None:
    model = DivisionModel(-4e-6, (150.0, 130.0), (320, 240), pixel_aspect=1.2, lam2=-1e-11)
    rays = pixel_rays(model, 250.0, margin=3)
    assert rays.x.shape == (246, 326)
    expected = (model.undistort([[40.0, 200.0]]) - model.center)[0] * (1.2, 1.0) / 250
    found = rays.x[200 + 3, 40 + 3], rays.y[200 + 3, 40 + 3]
    np.testing.assert_allclose(found, expected, rtol=1e-5)
    # The footprint is the root of the area between neighbouring rays.
    (a, b), (c, d) = ((np.gradient(v, axis=1), np.gradient(v, axis=0)) for v in (rays.x, rays.y))
    area = np.abs(a * d - b * c)[1:-1, 1:-1]
    # In frame pixels; an area of square pixels is 1.2 times as large.
    np.testing.assert_allclose(rays.footprint[1:-1, 1:-1] ** 2 * 1.2, area, rtol=2e-2)


def test_the_pole_of_a_model_on_a_pixel_is_seen_by_none() -> None:
    """In single precision its denominator rounds to 0 there at some focal lengths."""
    model = DivisionModel(-1e-4, (0.0, 0.0), (120, 120))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for focal in np.linspace(50, 200, 40):
            rays = pixel_rays(model, focal)
            assert not np.isinf(rays.x[0, 100])
            assert np.isnan(rays.x[0, 101])


def test_a_zoom_path_rests_at_equal_neighbours_and_starts_gently() -> None:
    path = zoom_path((1.0, 2.0, 2.0, 1.0), 9.0)
    found = [path.at(t) for t in (-5, 0, 3, 4.5, 6, 9, 20)]
    np.testing.assert_allclose(found, [1, 1, 2, 2, 2, 1, 1])
    assert path.at(1.5) == pytest.approx(np.sqrt(2))
    steps = np.diff([path.at(t) for t in np.linspace(0, 3, 50)])
    assert (steps > 0).all()
    assert steps[0] < 0.2 * steps.max()


def test_a_zoom_path_passes_through_its_zooms_without_a_stop() -> None:
    path = zoom_path((1.0, 1.4, 2.0, 3.0), 3.0)
    np.testing.assert_allclose([path.at(t) for t in range(4)], [1.0, 1.4, 2.0, 3.0])
    rates = np.diff(np.log([path.at(t) for t in np.linspace(0.8, 2.2, 50)]))
    assert rates.min() > 0.5 * rates.max()


@pytest.mark.parametrize("keys", [(), ((0.0, 0.0),), ((1.0, 1.0), (1.0, 2.0))])
def test_a_senseless_zoom_path_is_refused(keys: tuple[tuple[float, float], ...]) -> None:
    with pytest.raises(UsageError):
        ZoomPath(keys)


def test_the_eye_returns_from_its_approach() -> None:
    motion = EyeMotion(approach=0.3, duration=10.0)
    assert motion.at(0.0).position[2] == 0
    assert motion.at(5.0).position[2] == pytest.approx(0.3)
    assert motion.at(10.0).position[2] == pytest.approx(0)
    turned = Eye(yaw=10, pitch=-5, roll=30).rotation
    np.testing.assert_allclose(turned @ turned.T, np.eye(3), atol=1e-12)
    # Yaw to the right looks at +x, pitch down at +y.
    assert Eye(yaw=10).rotation[0, 2] > 0
    assert Eye(pitch=10).rotation[1, 2] > 0
