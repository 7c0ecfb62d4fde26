"""The visible circle against frames whose circle is known, and frames that have none."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from endocal.benchmarks.looks import LOOKS, TOLERANCE, distance, random_look
from endocal.benchmarks.plain_frames import KINDS, random_plain_frame
from endocal.benchmarks.rim_frames import TROUBLES, RimFrame, random_rim_frame
from endocal.boundary.circle import Boundary
from endocal.boundary.detect import find_boundary, locate_boundary

SIZE = (720, 540)


def error(found: Boundary | None, truth: RimFrame) -> float:
    """The larger of the diameter's and the centre's error, px of the height."""
    assert found is not None, f"{truth.trouble}, seed {truth.seed}: nothing found"
    dx = (found.center[0] - truth.center[0]) * truth.pixel_aspect
    dy = found.center[1] - truth.center[1]
    return max(abs(found.diameter - truth.diameter), float(np.hypot(dx, dy)))


# What an edge of the truth's blur and noise allows: a step is seen to a tenth of a pixel on a hundred radii,
# half a pixel where only one side of the circle is in the frame; a light that fades to black only to 2 px.
LIMITS = {"cut 3 sides": 1.0, "vignette": 2.0}


@pytest.mark.parametrize("trouble", [t for t in TROUBLES if t != "all at once"])
def test_the_circle_is_found_to_a_fraction_of_a_pixel(trouble: str) -> None:
    errors = []
    for seed in range(5):
        frame = random_rim_frame(seed, trouble, SIZE)
        errors.append(error(find_boundary(frame.image, frame.pixel_aspect), frame))
    assert max(errors) <= LIMITS.get(trouble, 0.5), errors


def test_many_troubles_at_once_leave_it_within_two_pixels() -> None:
    frames = [random_rim_frame(seed, "all at once", SIZE) for seed in range(20)]
    found = [find_boundary(f.image, f.pixel_aspect) for f in frames]
    errors = [error(b, f) for b, f in zip(found, frames, strict=True) if b is not None]
    # A frame may be beyond recognition; a wrong circle is worse than none.
    assert len(errors) >= 18
    assert max(errors) <= 4
    assert np.median(errors) <= 0.5


def faded_circle(seed: int) -> RimFrame:
    """A circle whose light fades to black at its rim, under noise that black clips."""
    center, diameter = (361.3, 268.2), 430.0
    y, x = np.mgrid[0 : SIZE[1], 0 : SIZE[0]]
    r = np.hypot(x - center[0], y - center[1]) / (diameter / 2)
    light = 120 * np.clip(1 - r**2, 0, 1)
    light += np.random.default_rng(seed).normal(0, 7, light.shape)
    return RimFrame(
        np.clip(np.rint(light), 0, 255).astype(np.uint8), center, diameter, 1.0, "noise", seed
    )


@pytest.mark.parametrize("directions", [(0.6,), (0.3, 1.2), (0.6, 2.5, 4.0)])
def test_instruments_that_shine_up_to_a_faded_rim_do_not_hide_it(
    directions: tuple[float, ...],
) -> None:
    frame = faded_circle(1)
    image = frame.image.copy()
    y, x = np.mgrid[0 : SIZE[1], 0 : SIZE[0]].astype(np.float64)
    x, y = x - frame.center[0], y - frame.center[1]
    for angle in directions:
        along, across = x * np.cos(angle) + y * np.sin(angle), y * np.cos(angle) - x * np.sin(angle)
        shaft = (np.abs(across) < 14) & (along > 60) & (np.hypot(x, y) < frame.diameter / 2)
        image[shaft] = 240
    assert error(find_boundary(image), frame) <= 1.5


@pytest.mark.parametrize(("seed", "trouble"), [(687458, "noise"), (7, "all at once")])
def test_a_corner_whose_noise_seems_small_by_chance_hides_no_rim(seed: int, trouble: str) -> None:
    frame = random_rim_frame(seed, trouble)
    assert error(find_boundary(frame.image, frame.pixel_aspect), frame) <= 0.5


def test_noise_that_is_clipped_at_black_does_not_shrink_a_faded_circle() -> None:
    frames = [faded_circle(seed) for seed in range(12)]
    found = [find_boundary(f.image) for f in frames]
    diameters = [b.diameter for b in found if b is not None]
    assert len(diameters) == 12
    # Clipping lifts what is darker than the noise; taken as it is, that took 3 px off the diameter.
    assert np.mean(diameters) == pytest.approx(430, abs=0.6)
    assert np.ptp(diameters) <= 3


@pytest.mark.parametrize("kind", KINDS)
def test_a_frame_without_a_circle_gives_none(kind: str) -> None:
    for n in range(6):
        image, drawn = random_plain_frame(KINDS.index(kind) + n * len(KINDS))
        assert drawn == kind
        assert find_boundary(image) is None


# Seeds of looks that were taken for a fade; the first six of the others.
SEEDS = {"glowing rim": (41, 45, 80, 89), "rounded box": (32, 36, 67, 71, 99)}
# Of these frames so many show their circle at least; where it is not told it may be none.
SEEN = {
    "flat sides": 6,
    "side panel": 3,
    "corner mark": 3,
    "reflection ring": 3,
    "dim": 2,
    "white balance": 6,
    "smoke-filled": 6,
    "outside the body": 5,
}


@pytest.mark.parametrize("kind", LOOKS)
def test_what_else_is_about_a_circle_is_not_taken_for_it(kind: str) -> None:
    seen = 0
    for seed in SEEDS.get(kind, range(6)):
        look = random_look(seed, kind)
        found = find_boundary(look.image)
        if found is not None:
            assert distance(found, look) <= TOLERANCE + look.softness, seed
            seen += 1
    assert seen >= SEEN.get(kind, 0)


@pytest.mark.parametrize("shape", [(1, 1), (2, 2), (9, 300), (40, 40)])
@pytest.mark.parametrize("level", [0, 128, 255])
def test_an_even_or_tiny_frame_gives_none(shape: tuple[int, int], level: int) -> None:
    assert find_boundary(np.full(shape, level, np.uint8)) is None


def test_a_bright_disc_on_a_dark_scene_is_no_boundary() -> None:
    y, x = np.mgrid[0:540, 0:720]
    scene = 40 + 25 * np.sin(x / 23) * np.sin(y / 17)
    scene[np.hypot(x - 360, y - 270) < 200] = 220
    assert find_boundary(scene.astype(np.uint8)) is None


def test_colour_and_depth_change_nothing() -> None:
    frame = random_rim_frame(3, "instruments", SIZE)
    grey = find_boundary(frame.image)
    assert grey is not None
    colour = find_boundary(np.dstack([frame.image] * 3))
    assert colour == grey
    for bits in (10, 12, 16):
        deep = frame.image.astype(np.uint16) << (bits - 8)
        found = find_boundary(deep)
        assert found is not None
        # The interpolation of uint8 profiles rounds to whole levels, that of deeper ones does not.
        assert found.diameter == pytest.approx(grey.diameter, abs=0.05)
        assert found.center == pytest.approx(grey.center, abs=0.05)


def test_a_guess_changes_the_way_but_not_the_answer() -> None:
    frame = random_rim_frame(5, "cut 2 sides", SIZE)
    cold = find_boundary(frame.image)
    assert cold is not None
    near = Boundary((cold.center[0] + 2, cold.center[1] - 1), cold.diameter + 3, 0, 0)
    wrong = Boundary((100, 100), 300, 0, 0)
    for guess in (near, wrong):
        warm = find_boundary(frame.image, guess=guess)
        assert warm is not None
        assert warm.diameter == pytest.approx(cold.diameter, abs=0.1)
        assert warm.center == pytest.approx(cold.center, abs=0.1)


def test_pillarbox_edges_are_not_taken_for_the_rim() -> None:
    frame = random_rim_frame(2, "cut 2 sides", (720, 540))
    boxed = np.zeros((540, 960), np.uint8)
    boxed[:, 120:840] = frame.image
    cut = boxed.copy()
    x, half = frame.center[0] + 120, frame.diameter / 2
    # Bars that cut the circle on the left and the right as well.
    cut[:, : round(x - 0.85 * half)] = 0
    cut[:, round(x + 0.85 * half) :] = 0
    for image in (boxed, cut):
        found = find_boundary(image)
        assert found is not None
        assert found.diameter == pytest.approx(frame.diameter, abs=1)
        assert found.center == pytest.approx((x, frame.center[1]), abs=1)
    assert find_boundary(cut).visible < find_boundary(boxed).visible  # type: ignore[union-attr]


def test_area_and_visible_fraction_are_those_of_the_disc_in_the_frame() -> None:
    frame = random_rim_frame(4, "cut 3 sides", SIZE)
    found = find_boundary(frame.image)
    assert found is not None
    y, x = np.mgrid[0 : SIZE[1], 0 : SIZE[0]]
    inside = np.hypot(x - found.center[0], y - found.center[1]) <= found.diameter / 2
    assert found.area == pytest.approx(inside.sum(), rel=1e-3)
    angle = np.linspace(0, 2 * np.pi, 20000, endpoint=False)
    rim_x = found.center[0] + found.diameter / 2 * np.cos(angle)
    rim_y = found.center[1] + found.diameter / 2 * np.sin(angle)
    seen = (np.abs(rim_x - 359.5) <= 360) & (np.abs(rim_y - 269.5) <= 270)
    assert found.visible == pytest.approx(seen.mean(), abs=1e-3)


def test_the_stated_uncertainty_covers_the_noise() -> None:
    base = random_rim_frame(7, "plain", SIZE)
    rng = np.random.default_rng(0)
    diameters, sigmas = [], []
    for _ in range(20):
        noisy = np.clip(base.image + rng.normal(0, 6, base.image.shape), 0, 255).astype(np.uint8)
        located = locate_boundary(noisy)
        assert located is not None
        diameters.append(located.boundary.diameter)
        sigmas.append(located.diameter_sigma)
    assert np.std(diameters) <= 2 * np.mean(sigmas)


@pytest.mark.parametrize("name", ["box_trainer_full_circle.jpg", "fetoscopy_470_a.png", "clip"])
def test_a_real_rim_that_is_cut_is_off_by_no_more_than_it_says(real_data: Path, name: str) -> None:
    folder = real_data / "endoscopy"
    if name == "clip":
        read, picture = cv2.VideoCapture(str(folder / "laparoscopy_1280x720.mp4")).read()
        assert read
    else:
        picture = cv2.imread(str(folder / name))
    whole = find_boundary(picture)
    assert whole is not None
    h, w = picture.shape[:2]
    for crop in (
        np.s_[:, : w * 7 // 10],
        np.s_[:, w * 3 // 10 :],
        np.s_[h // 5 :],
        np.s_[: -h // 5],
    ):
        located = locate_boundary(np.ascontiguousarray(picture[crop]))
        assert located is not None
        off = abs(located.boundary.diameter - whole.diameter)
        assert off <= 2.5 * located.uncertainty


def test_a_glare_beyond_a_part_of_the_rim_leads_no_wider_look_astray(real_data: Path) -> None:
    # On the right, tissue at the rim is so bright that the outside is as bright as the content on the left.
    picture = cv2.imread(str(real_data / "endoscopy/t80_VID03_000000.png"))
    for height in (336, 384, 432, 480):
        found = find_boundary(np.ascontiguousarray(picture[:height]))
        assert found is not None
        assert found.diameter == pytest.approx(866, abs=3)


# What the eye reads off enlargements of these pictures: diameter and centre, px.
REAL = {
    "endoscopy/box_trainer_full_circle.jpg": (984, (648, 507)),
    "endoscopy/fetoscopy_470_a.png": (447, (234, 237)),
    "endoscopy/fetoscopy_470_b.png": (447, (234, 236)),
    "endoscopy/t80_VID03_000000.png": (865, (440, 264)),
    "endoscopy/t80_VID03_000060.png": (865, (435, 268)),
    "endoscopy/t80_VID03_000120.png": (865, (437, 266)),
    "boards/dots_fetoscope/sample_001__frame_001.jpg": (650, (417, 341)),
    "boards/dots_fetoscope/sample_002__frame_001.jpg": (652, (979, 545)),
}


@pytest.mark.parametrize("name", REAL)
def test_real_rims_are_found_where_the_eye_sees_them(real_data: Path, name: str) -> None:
    diameter, center = REAL[name]
    found = find_boundary(cv2.imread(str(real_data / name)))
    assert found is not None
    assert found.diameter == pytest.approx(diameter, abs=4)
    assert found.center == pytest.approx(center, abs=4)


@pytest.mark.parametrize("lens", ["gopro3", "endoscope_6080hd", "storz", "viking"])
def test_real_full_frames_have_none(real_data: Path, lens: str) -> None:
    for path in sorted((real_data / "boards" / lens).iterdir()):
        assert find_boundary(cv2.imread(str(path))) is None, path.name
