"""Whole calibrations: truth made by us and recovered, refusals, and the real pictures."""

import json
from typing import Any

import cv2
import numpy as np
import pytest

from endocal import CalibrationSpec, calibrate
from endocal.benchmarks.corner_floor import least_straightness
from endocal.benchmarks.corner_score import straightness
from endocal.calibration import lens_fit
from endocal.calibration.calibrate import calibrate_jointly
from endocal.errors import CalibrationError, EndocalError, UsageError
from endocal.files import dumps
from endocal.synth.board import render_board, true_corners
from endocal.synth.camera import ContentCircle
from endocal.synth.fisheye_boards import fisheye_board
from endocal.synth.random import random_board

from .scenes import board


def check(scene, lam: float = 0.002, center: float = 0.2, **spec):
    """Calibrate a scene and hold it to its truth, within relative ``lam`` and ``center`` px."""
    result = calibrate(render_board(scene), CalibrationSpec(**spec))
    assert result.model.lam == pytest.approx(scene.model.lam, rel=lam)
    assert result.model.center == pytest.approx(scene.model.center, abs=center)
    return result


def test_a_plain_board() -> None:
    result = check(board(), lam=0.001, center=0.1)
    assert result.quality.verdict == "good"
    assert result.quality.rms < 0.1 < 1 < result.quality.rms_before
    assert result.boundary is None
    z = (result.model.lam + 2.4e-6) / result.uncertainty.lam
    assert abs(z) < 5


@pytest.mark.parametrize(
    "scene",
    [
        board(kind="lines", tilt=40, axis=20),
        board(noise=8.0, blur=1.8, gamma=2.2, vignetting=0.6, jpeg=75),
        board(comb=(2.5, 0.4)),
        board(circle=ContentCircle((322.0, 236.0), 440.0, 2.0), lam=-1.2e-5, square=30.0),
        board(lam=-3e-7),
        board(lam=1.2e-6),
    ],
    ids=["lines", "degraded", "interlaced", "strong, in a circle", "weak", "pincushion"],
)
def test_harder_pictures(scene) -> None:
    check(scene, lam=0.01, center=1.0)


def test_a_sheet_before_a_black_background_keeps_its_edges() -> None:
    # Its background touches the corners of the frame, as the surround of a circle would.
    scene = random_board(64300020)
    result = calibrate(render_board(scene))
    assert result.boundary is None
    assert result.model.center == pytest.approx(scene.model.center, abs=0.7)


def test_a_second_parameter_that_is_not_told_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    plain = lens_fit.refine

    def one_parameter(*arguments: Any) -> Any:
        return plain(*arguments) if len(arguments) == 4 else []

    monkeypatch.setattr(lens_fit, "refine", one_parameter)
    result = calibrate(render_board(board()), CalibrationSpec(model="division2"))
    assert result.model.lam2 == 0
    assert result.quality.verdict == "doubtful"
    assert "this is the one-parameter model" in result.quality.reasons[0]


def test_non_square_pixels() -> None:
    aspect = 16 / 15
    scene = board(size=(720, 576), center=(362.0, 284.0), pixel_aspect=aspect)
    picture = render_board(scene)
    joint = calibrate_jointly([picture], CalibrationSpec(pixel_aspect=aspect))
    model, stated = joint.calibration.model, joint.calibration.uncertainty
    assert model.pixel_aspect == aspect
    assert model.lam == pytest.approx(scene.model.lam, rel=0.002)
    assert model.center == pytest.approx(scene.model.center, abs=0.2)
    # The workings are in square pixels; the centre, and how sure it is, in the frame's own.
    square = np.sqrt(np.diag(joint.workings.covariance))
    assert (stated.lam, *stated.center) == pytest.approx(square / (1.0, aspect, 1.0))
    wrong = calibrate(picture).model.lam
    assert abs(wrong / scene.model.lam - 1) > 0.005


def test_two_parameters() -> None:
    scene = board(lam=-1.2e-6, lam2=-6e-12)
    result = check(scene, lam=0.05, center=0.5, model="division2")
    assert result.model.lam2 == pytest.approx(-6e-12, rel=0.1)
    assert result.uncertainty.lam2 > 0


def test_a_given_centre_and_region() -> None:
    scene = board()
    spec = CalibrationSpec(center=(325.0, 233.0), roi=(40, 30, 560, 420))
    result = calibrate(render_board(scene), spec)
    assert result.model.center == (325.0, 233.0)
    assert result.model.lam == pytest.approx(-2.4e-6, rel=0.002)
    assert result.uncertainty.center_given


def test_a_centre_given_wrong_is_suspected() -> None:
    result = calibrate(render_board(board()), CalibrationSpec(center=(365.0, 285.0)))
    assert result.quality.verdict == "doubtful"
    assert any("the centre that was given is wrong" in reason for reason in result.quality.reasons)


def test_sixteen_bits_and_colour_give_the_same() -> None:
    grey = render_board(board())
    a = calibrate(grey).model
    b = calibrate(grey.astype(np.uint16) * 257).model
    c = calibrate(cv2.cvtColor(grey, cv2.COLOR_GRAY2BGR)).model
    assert b.lam == pytest.approx(a.lam, rel=1e-4)
    assert c.lam == pytest.approx(a.lam, rel=1e-4)


def test_the_same_input_gives_the_same_bytes() -> None:
    picture = render_board(board(noise=6.0))
    before = cv2.getNumThreads()
    first = dumps(calibrate(picture))
    cv2.setNumThreads(1)
    try:
        assert dumps(calibrate(picture)) == first
    finally:
        cv2.setNumThreads(before)


def test_the_bare_search_is_near() -> None:
    scene = board()
    result = calibrate(render_board(scene), CalibrationSpec(refine=False))
    # What the article's method reaches alone; issue of the search, not of the fit.
    assert result.model.lam == pytest.approx(scene.model.lam, rel=0.1)
    assert result.model.center == pytest.approx(scene.model.center, abs=10)
    assert result.uncertainty is None
    assert not result.source.refined


@pytest.mark.parametrize("blobs", [False, True])
def test_a_picture_without_lines_is_no_evidence(blobs: bool) -> None:
    seen = render_board(board())
    empty = np.full_like(seen, 128)
    if blobs:
        for i in range(60):
            cv2.circle(empty, (30 + 97 * i % 580, 30 + 53 * i % 420), 14, (40, 40, 40), -1)
    joint = calibrate_jointly([seen, empty])
    assert joint.silent == (1,)
    assert joint.left_out == ()
    assert joint.rms[1] is None
    assert joint.calibration.model == calibrate(seen).model


def test_the_edges_do_not_depend_on_the_number_of_threads() -> None:
    threads = cv2.getNumThreads()
    try:
        found = []
        for count in (1, 2, 3):
            cv2.setNumThreads(count)
            found.append(calibrate(render_board(board(noise=6.0, seed=3))).model)
            assert cv2.getNumThreads() == count
    finally:
        cv2.setNumThreads(threads)
    assert found[0] == found[1] == found[2]


def test_several_pictures_share_one_model_and_a_stranger_is_left_out() -> None:
    mates = [
        render_board(board(rotation=r, tilt=t, seed=r)) for r, t in ((5, 10), (40, 30), (70, 25))
    ]
    circle = ContentCircle((330.0, 236.0), 440.0)
    stranger = render_board(board(lam=-5e-6, center=(300.0, 250.0), circle=circle))
    joint = calibrate_jointly([*mates, stranger])
    assert joint.left_out == (3,)
    assert joint.rms[3] is None
    assert all(r < 0.2 for r in joint.rms[:3])
    assert joint.calibration.model.lam == pytest.approx(-2.4e-6, rel=0.001)
    alone = calibrate(mates[0]).uncertainty.lam
    assert joint.calibration.uncertainty.lam < alone
    assert joint.calibration.boundary is None, "the stranger alone shows a circle"


@pytest.mark.parametrize("factor", [1.1, 1.5])
def test_two_pictures_of_different_lenses_are_doubted(factor: float) -> None:
    first = render_board(board(lam=-3e-6))
    second = board(lam=-3e-6 * factor, axis=100, rotation=40, seed=7)
    quality = calibrate([first, render_board(second)]).quality
    assert quality.verdict == "doubtful"
    assert "do not go together" in quality.reasons[0]
    mate = render_board(board(lam=-3e-6, axis=100, rotation=40, seed=7))
    assert calibrate([first, mate]).quality.verdict == "good"


def test_a_picture_that_does_not_go_with_the_other_is_told_by_its_own_points() -> None:
    second = board(lam=-4.5e-6, axis=100, rotation=40, seed=7)
    joint = calibrate_jointly([render_board(board(lam=-3e-6)), render_board(second)])
    quality = joint.calibration.quality
    # To the other's lens most of it outlies.
    assert quality.outlying > 0.3
    assert joint.rms[0] < 0.1 < 0.8 < joint.rms[1]
    assert [reason for reason in quality.reasons if "do not follow" in reason] == []


def test_two_boards_of_which_one_tells_the_model_are_doubted() -> None:
    picture = render_board(board(rotation=5))
    other = render_board(board(tilt=35, axis=210, rotation=-4, seed=2))
    picture[:, 240:] = other[:, 240:]
    quality = calibrate(picture).quality
    assert quality.rms < 0.1
    assert quality.outlying > 0.2
    assert quality.verdict == "doubtful"
    assert "of the points do not follow their lines" in " ".join(quality.reasons)


def test_pictures_of_two_zoom_settings_are_doubted() -> None:
    poses = ((100, 10, 5), (20, 30, 40))
    at = [
        [board(lam=lam, axis=a, tilt=t, rotation=r) for a, t, r in poses]
        for lam in (-3e-6, -2.85e-6)
    ]
    joint = calibrate_jointly([render_board(scene) for setting in at for scene in setting])
    assert joint.left_out == ()
    assert joint.calibration.quality.verdict == "doubtful"
    assert "the 4 pictures do not go together" in joint.calibration.quality.reasons[0]


# Of the last one nothing is even: small squares fill all that is lit.
@pytest.mark.parametrize("seed", [*range(900, 908), 5089])
def test_random_boards_are_found_and_right(seed: int) -> None:
    scene = random_board(seed)
    result = calibrate(render_board(scene))
    assert result.model.lam == pytest.approx(scene.model.lam, rel=0.02)
    assert result.quality.verdict == "good"


def blank() -> np.ndarray:
    return np.full((480, 640), 128, np.uint8)


def noise() -> np.ndarray:
    return np.random.default_rng(0).integers(0, 256, (480, 640), np.uint8)


def circle() -> np.ndarray:
    return cv2.circle(np.full((480, 640), 20, np.uint8), (320, 240), 150, 220, -1, cv2.LINE_AA)


WORDS = ["ipsum", "dolor", "sit", "amet", "lorem"]


def text() -> np.ndarray:
    page = np.full((700, 560), 245, np.uint8)
    for row in range(24):
        line = " ".join(WORDS[(row + k) % 5] for k in range(6))
        cv2.putText(
            page, line, (20, 30 + 28 * row), cv2.FONT_HERSHEY_SIMPLEX, 0.6, 20, 1, cv2.LINE_AA
        )
    return page


def one_bar() -> np.ndarray:
    return cv2.line(np.full((480, 640), 200, np.uint8), (30, 100), (600, 140), 20, 6, cv2.LINE_AA)


@pytest.mark.parametrize(
    "picture",
    [blank(), noise(), circle(), one_bar(), text()],
    ids=["blank", "noise", "circle", "one bar", "text"],
)
def test_pictures_without_lines_are_refused(picture: np.ndarray) -> None:
    try:
        result = calibrate(picture)
    except EndocalError:
        return
    assert result.quality.verdict == "failed"


def test_options_that_make_no_sense() -> None:
    wrong: tuple[tuple[str, Any], ...] = (
        *(("samples", v) for v in (2, 2.5, True, 100_000, np.nan)),
        *(("sobel", v) for v in (20, 21.0, 33)),
        ("model", "fisheye"),
        *(("center", v) for v in ("left", (3.0, 3.0, 3.0), [3.0, 3.0], (np.nan, 3.0), ("1", "2"))),
        *(("pixel_aspect", v) for v in (0, -1.0, np.nan, np.inf, 100_000.0, "1")),
        *(("center_region", v) for v in (np.nan, -0.1, np.inf)),
        *(("epsilon", v) for v in (0.0, np.nan, np.inf)),
        ("max_rounds", 0),
        *(("roi", v) for v in ((0, 0, 10), (0.0, np.nan, 10.0, 10.0), (0, 0, 0, 10))),
        *(("refine", v) for v in ("no", 1, None)),
    )
    for name, value in wrong:
        with pytest.raises(UsageError, match=name.replace("_", ".") + ".*needed"):
            CalibrationSpec(**{name: value})
    for sobel in (2, 20):
        with pytest.raises(UsageError, match="odd number from 3 to 31"):
            CalibrationSpec(sobel=sobel)
    with pytest.raises(UsageError, match=r"--no-refine.*one parameter"):
        CalibrationSpec(model="division2", refine=False)
    CalibrationSpec(center=(np.float64(3), 4), samples=np.int64(8), pixel_aspect=np.float32(1.5))
    picture = render_board(board())
    with pytest.raises(UsageError, match="640x480"):
        calibrate(picture, CalibrationSpec(roi=(600, 10, 50, 50)))
    with pytest.raises(UsageError, match="outside"):
        calibrate(picture, CalibrationSpec(center=(5000.0, 10.0)))
    with pytest.raises(EndocalError, match="NoneType"):
        calibrate(None)  # what cv2.imread gives for a picture that is not there
    with pytest.raises(UsageError, match="hewg"):
        calibrate(render_board(board()), CalibrationSpec(method="magic"))


# cal0001, cal0500, cal1000: lambda within 8 % of -2.8e-6, straightness on the corners at most 0.45 px.
@pytest.mark.parametrize("name", ["6080HD.cal0001.png", "6080HD.cal0500.png", "6080HD.cal1000.png"])
def test_the_endoscope(real_data, name: str) -> None:
    folder = real_data / "boards"
    model = calibrate(cv2.imread(str(folder / "endoscope_6080hd" / name))).model
    assert model.lam == pytest.approx(-2.8e-6, rel=0.08)
    truth = json.loads((folder / "corners.json").read_text())[f"endoscope_6080hd/{name}"]
    assert corner_straightness(model, truth) < 0.45


@pytest.mark.parametrize("turns", [0, 1], ids=["as it is", "turned left"])
def test_a_circular_fisheye_with_the_board_at_its_rim(real_data, turns: int) -> None:
    """Each look at this picture misses corners near the pole of the model, which decide; others show them."""
    folder = real_data / "boards"
    picture = cv2.imread(str(folder / "fisheye1" / "Fisheye1_7.jpg"))
    entry = json.loads((folder / "corners.json").read_text())["fisheye1/Fisheye1_7.jpg"]
    x, y = np.array(entry["corners"]).T
    turned = {**entry, "corners": np.stack([y, picture.shape[1] - 1 - x], axis=1)}
    result = calibrate(np.rot90(picture, turns).copy())
    score = corner_straightness(result.model, turned if turns else entry)
    assert score < 1.2 * entry["floor_division"]
    assert result.quality.verdict == "doubtful"


def test_how_far_out_two_parameters_may_not_fold_is_told_by_the_corners() -> None:
    """A lens by a series: not folding over all of the content costs the lines little, the corners much."""
    scene = fisheye_board(49)
    corners, seen = true_corners(scene)
    assert seen.all()
    model = calibrate(render_board(scene), CalibrationSpec(model="division2")).model
    assert (
        straightness(corners, model) < 1.2 * least_straightness(corners, model.size, "division2")[0]
    )


def corner_straightness(model, entry) -> float:
    """The straightness of rows and columns of corners, px, as the folder's README defines it."""
    a, b = entry["grid"]
    shapes = [np.reshape(entry["corners"], (n, m, 2)) for n, m in ((a, b), (b, a))]
    seen = min(shapes, key=lambda s: np.linalg.norm(np.diff(s, axis=1), axis=-1).max())
    corrected = model.undistort(seen)
    corrected = corrected * (spacing(seen) / spacing(corrected))
    squares = []
    for lines in (corrected, corrected.transpose(1, 0, 2)):
        centred = lines - lines.mean(axis=1, keepdims=True)
        squares.append(np.linalg.svd(centred, compute_uv=False)[:, 1] ** 2 / lines.shape[1])
    return float(np.sqrt((squares[0].mean() + squares[1].mean()) / 2))


def spacing(grid: np.ndarray) -> float:
    steps = [np.linalg.norm(np.diff(grid, axis=k), axis=-1).ravel() for k in (0, 1)]
    return float(np.concatenate(steps).mean())


def test_dots_are_refused(real_data) -> None:
    for path in sorted((real_data / "boards" / "dots_fetoscope").iterdir()):
        try:
            result = calibrate(cv2.imread(str(path)))
        except EndocalError:
            continue
        assert result.quality.verdict == "failed"


@pytest.mark.parametrize("axis", [300, 360, 420])
def test_lines_that_tell_no_lens_are_refused(axis: int) -> None:
    """Parabolas of one kind are straight under a centre far outside the picture."""
    h, w = 540, 720
    y, x = np.mgrid[:h, :w]
    stripes = np.floor((y + ((x - axis) / 45.0) ** 2) / 30) % 2
    picture = cv2.GaussianBlur((40 + 170 * stripes).astype(np.uint8), (0, 0), 1.0)
    words = ""
    try:
        quality = calibrate(picture).quality
        # A centre less far outside is within what a model may have, and told to be wrong.
        assert quality.verdict == "failed"
        words = quality.reasons[0]
    except CalibrationError as error:
        words = str(error)
    assert "tell no lens" in words or "the centre came out far from the middle" in words
