"""Following the zoom through small clips whose zoom is known."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from itertools import count
from typing import Any

import cv2
import numpy as np
import pytest

from endocal.benchmarks.rim_frames import texture
from endocal.errors import InputError
from endocal.zoom.anchor import AnchorSpec
from endocal.zoom.follow import FollowSpec, ZoomEstimate, ZoomFollower
from endocal.zoom.parallax import ScaleStep, SceneShape
from endocal.zoom.table import LOOKUPS, Setting, ZoomTable

SIZE = (480, 360)
MIDDLE = (241.0, 178.0)
STRENGTH = -1.3
TABLE = ZoomTable(
    tuple(Setting(STRENGTH / d**2, MIDDLE, d, 60000 + 100 * d) for d in (280.0, 360.0, 480.0)), SIZE
)
SCENE, OTHER_SCENE = (
    (40 + 200 * texture(np.random.default_rng(seed), (1000, 750), 1.2)).astype(np.uint8)
    for seed in (8, 9)
)
BLACK = np.full((360, 480), 6, np.uint8)


def frame(
    diameter: float, seed: int = 0, noise: float = 2.0, scene: np.ndarray = SCENE
) -> np.ndarray:
    """A still scene and its circle, magnified together."""
    scale = diameter / 400
    shift = (MIDDLE[0] - scale * 500, MIDDLE[1] - scale * 375)
    matrix = np.array([[scale, 0, shift[0]], [0, scale, shift[1]]])
    scene = cv2.warpAffine(scene, matrix, SIZE, flags=cv2.INTER_AREA).astype(np.float64)
    y, x = np.mgrid[0 : SIZE[1], 0 : SIZE[0]]
    scene *= np.clip(diameter / 2 - np.hypot(x - MIDDLE[0], y - MIDDLE[1]) + 0.5, 0, 1)
    scene += 5 + np.random.default_rng(seed).normal(0, noise, scene.shape)
    return np.clip(np.rint(scene), 0, 255).astype(np.uint8)


def follow(
    follower: ZoomFollower, frames: Iterable[np.ndarray], times: Iterable[float] = ()
) -> Iterator[ZoomEstimate]:
    """Follow frames at these times, s; at 25 a second without."""
    for image, time in zip(frames, times or (i / 25 for i in count()), strict=False):
        yield follower.update(image, time)


def test_a_still_clip_with_noise_gives_a_still_lambda() -> None:
    found = list(follow(ZoomFollower(TABLE), (frame(330, seed, 6.0) for seed in range(60))))
    lam = np.array([e.model.lam for e in found])
    assert lam.std() / abs(lam.mean()) <= 0.002
    assert lam.mean() == pytest.approx(STRENGTH / 330**2, rel=0.005)
    # So still that the remapper hardly ever has to bake anew.
    assert len({id(e.model) for e in found}) <= 6
    assert all(e.source == "rim" for e in found)


@pytest.mark.parametrize("lookup", LOOKUPS)
def test_a_zoom_is_followed_frame_by_frame(lookup: str) -> None:
    diameters = 300 * np.exp(0.01 * np.arange(40))
    follower = ZoomFollower(TABLE, FollowSpec(lookup=lookup))
    found = list(follow(follower, (frame(d, i) for i, d in enumerate(diameters))))
    errors = [math.log(e.diameter / d) for e, d in zip(found, diameters, strict=True)]
    # A frame late is 1 %; the first frames may be two late.
    assert np.abs(errors[:3]).max() <= 0.021
    assert np.abs(errors[3:]).max() <= 0.003


def test_beyond_the_rim_the_picture_tells_the_zoom_until_the_rim_is_back() -> None:
    out = 400 * np.exp(np.concatenate([[0] * 5, 0.015 * np.arange(50), [0.75] * 20]))
    diameters = np.concatenate([out, out[::-1]])
    found = list(follow(ZoomFollower(TABLE), (frame(d, i) for i, d in enumerate(diameters))))
    diagonal = math.hypot(*SIZE)
    seen = diameters < 0.9 * diagonal
    gone = diameters > 1.03 * diagonal
    assert gone.sum() > 60
    errors = np.array(
        [e.model.lam * d**2 / STRENGTH - 1 for e, d in zip(found, diameters, strict=True)]
    )
    assert np.median(np.abs(errors[seen])) <= 0.01
    assert np.percentile(np.abs(errors[seen]), 95) <= 0.03
    assert np.percentile(np.abs(errors[gone]), 95) <= 0.05
    sources = np.array([e.source for e in found])
    # Where the zoom sets in, one measurement has to wait for the next.
    assert (sources[seen] == "rim").mean() > 0.9
    assert set(sources[gone]) <= {"tracked", "held"}
    assert (sources[gone] == "tracked").mean() > 0.9
    doubt = np.array([e.relative_uncertainty for e in found])
    # It grows from frame to frame, but for those of a match with a key picture; never below the match's own.
    matched = np.diff(doubt[gone]) <= 0
    assert matched.mean() < 1.5 / 25 / AnchorSpec().interval
    assert doubt[gone].min() > AnchorSpec().least / 2
    assert sources[-1] == "rim"
    assert doubt[-1] < 0.002


@pytest.mark.parametrize("jump", [1.2, 1 / 1.2])
def test_a_zoom_that_jumps_beyond_the_rim_is_followed(jump: float) -> None:
    there = 700 / math.sqrt(jump)
    out = 400 * np.exp(np.linspace(0, math.log(there / 400), 40))
    diameters = np.concatenate([[400.0] * 5, out, [there] * 15, [there * jump] * 20])
    found = list(follow(ZoomFollower(TABLE), (frame(d, i) for i, d in enumerate(diameters))))
    errors = [math.log(e.diameter / d) for e, d in zip(found, diameters, strict=True)]
    assert np.abs(errors[-35:]).max() < 0.01


@pytest.mark.parametrize("repeats", [lambda i: i % 2 == 1, lambda i: i % 5 in (1, 3)])
def test_repeated_frames_are_no_zoom_that_rests(repeats: Callable[[int], bool]) -> None:
    zoom = 400 * np.exp(np.concatenate([[0] * 6, 0.015 * np.arange(50), [0.75] * 20]))
    shown = [i - next(n for n in count() if not repeats(i - n)) for i in range(len(zoom))]
    images = {i: frame(zoom[i], i) for i in set(shown)}
    found = list(follow(ZoomFollower(TABLE), (images[i] for i in shown)))
    errors = [math.log(e.diameter / zoom[i]) for e, i in zip(found, shown, strict=True)]
    assert np.abs(errors[15:]).max() < 0.01


def test_a_picture_that_freezes_changes_nothing() -> None:
    still = beyond_the_rim()
    found = with_rim_out(*still, *[still[-1]] * 50, *still)
    assert {e.source for e in found} == {"tracked"}
    assert found[-1].diameter == pytest.approx(found[len(still) - 1].diameter, rel=0.002)
    assert found[-1].relative_uncertainty < 0.1


def test_steps_that_are_too_small_are_made_up_for(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = SceneShape.scale_between

    def partial(self: SceneShape, *arguments: Any) -> ScaleStep:
        step = whole(self, *arguments)
        return step._replace(logarithm=0.8 * step.logarithm, target=0.8 * step.target)

    monkeypatch.setattr(SceneShape, "scale_between", partial)
    diameters = 400 * np.exp(np.concatenate([[0] * 5, 0.015 * np.arange(50), [0.75] * 15]))
    gone = diameters > 1.03 * math.hypot(*SIZE)

    def error(spec: FollowSpec) -> float:
        found = follow(ZoomFollower(TABLE, spec), (frame(d, i) for i, d in enumerate(diameters)))
        errors = [math.log(e.diameter / d) for e, d in zip(found, diameters, strict=True)]
        return float(np.abs(errors)[gone][-15:].max())

    never = FollowSpec(anchor=AnchorSpec(interval=math.inf))
    assert error(FollowSpec()) < 0.015
    assert error(never) > 0.05


def test_one_dark_frame_and_one_false_circle_move_nothing() -> None:
    images = [frame(330, i) for i in range(30)]
    images[12] = np.full_like(images[12], 6)
    images[20] = frame(250, 20)
    found = list(follow(ZoomFollower(TABLE), images))
    diameters = np.array([e.diameter for e in found])
    assert diameters == pytest.approx(np.full(30, 330.0), rel=0.002)
    assert found[12].source == found[20].source == "held"
    assert {e.source for i, e in enumerate(found) if i not in (12, 20)} == {"rim"}


def test_with_nothing_to_see_the_zoom_is_held_and_grows_doubtful() -> None:
    images = [frame(330, i) for i in range(5)] + [BLACK] * 30
    found = list(follow(ZoomFollower(TABLE), images))
    assert {e.source for e in found[5:]} == {"held"}
    assert found[-1].diameter == pytest.approx(330, rel=0.003)
    doubt = [e.relative_uncertainty for e in found[5:]]
    assert (np.diff(doubt) > 0).all()
    assert doubt[-1] > 5 * doubt[0]


def followed_through_the_dark(diameters: np.ndarray, dark: int) -> tuple[np.ndarray, np.ndarray]:
    """Relative errors and stated doubts of frames of these diameters, ``dark`` of them black from 15 on."""
    images = [frame(d, i) for i, d in enumerate(diameters)]
    images[15 : 15 + dark] = [BLACK] * dark
    found = list(follow(ZoomFollower(TABLE), images))
    errors = np.array([math.log(e.diameter / d) for e, d in zip(found, diameters, strict=True)])
    return errors, np.array([e.relative_uncertainty for e in found])


def test_a_zoom_that_goes_on_in_the_dark_is_within_what_is_stated() -> None:
    errors, doubt = followed_through_the_dark(250 * np.exp(0.016 * np.arange(30)), dark=6)
    assert (np.abs(errors[15:]) <= 3 * doubt[15:] + 1e-3).all()
    assert abs(errors[20]) > 0.05
    assert np.abs(errors[25:]).max() < 0.003
    assert doubt[25:].max() < 0.003


def test_a_zoom_that_ends_in_the_dark_is_within_what_is_stated() -> None:
    diameters = 250 * np.exp(0.016 * np.minimum(np.arange(30), 15))
    errors, doubt = followed_through_the_dark(diameters, dark=4)
    assert (np.abs(errors[17:]) <= 3 * doubt[17:] + 1e-3).all()


def test_past_a_limit_of_doubt_tracking_becomes_holding() -> None:
    follower = ZoomFollower(TABLE, FollowSpec(limit=0.004))
    diameters = [500.0] * 5 + [650.0] * 5 + [620.0] * 140
    images = [frame(d, i % 7) for i, d in enumerate(diameters)]
    sources = [e.source for e in follow(follower, images)]
    assert sources[4] == "rim"
    assert sources[-1] == "held"
    assert "tracked" in sources
    assert sources.index("tracked") < len(sources) - 1 - sources[::-1].index("held")


def test_an_arc_of_the_rim_is_stated_to_tell_less_than_a_whole_one() -> None:
    """A real rim is no perfect circle: of its arc alone the width is known less well, in every frame."""
    whole, cut = (
        [*follow(ZoomFollower(TABLE), (frame(d, seed) for seed in range(12)))][-1]
        for d in (330.0, 500.0)
    )
    assert whole.source == cut.source == "rim"
    assert cut.relative_uncertainty > 2 * whole.relative_uncertainty


def test_what_the_model_stands_still_by_is_stated() -> None:
    # It stands still for 1 % here; the circle is 0.5 % wider from the tenth frame on.
    follower = ZoomFollower(TABLE, FollowSpec(still=(0.01, 0.01)))
    widths = [300.0] * 10 + [301.5] * 15
    *_, last = follow(follower, (frame(d, i) for i, d in enumerate(widths)))
    assert last.diameter == pytest.approx(300.0, rel=1e-3)
    assert last.relative_uncertainty > 0.004


def test_without_any_rim_the_zoom_is_not_guessed() -> None:
    with pytest.raises(InputError, match=r"3\.20 s.*--assume-diameter"):
        ZoomFollower(TABLE).update(frame(900), 3.2)


def test_an_assumed_diameter_holds_until_a_rim_is_seen() -> None:
    follower = ZoomFollower(TABLE, FollowSpec(assume_diameter=700))
    hidden = [frame(900, i) for i in range(4)]
    seen = [frame(400, i) for i in range(4)]
    found = list(follow(follower, hidden + seen))
    assert found[0].source == "given"
    assert found[0].diameter == pytest.approx(700)
    assert found[3].relative_uncertainty >= 0.05
    assert found[4].source == "rim"
    assert found[4].diameter == pytest.approx(400, rel=0.002)


def test_an_assumed_diameter_that_a_step_has_moved_is_given_no_more() -> None:
    moving = [frame(700 * math.exp(0.02 * i), i) for i in range(12)]
    found = list(follow(ZoomFollower(TABLE, FollowSpec(assume_diameter=700)), [*moving, BLACK]))
    assert [e.source for e in found] == ["given", *["tracked"] * 11, "held"]
    assert found[-1].diameter == pytest.approx(700 * math.exp(0.22), rel=0.02)


def test_frames_of_another_size_are_refused() -> None:
    with pytest.raises(InputError, match="480x360, not 240x180"):
        ZoomFollower(TABLE).update(np.zeros((180, 240), np.uint8))


def test_deep_frames_are_followed_as_well() -> None:
    found = list(
        follow(ZoomFollower(TABLE), (frame(330, i).astype(np.uint16) << 2 for i in range(5)))
    )
    assert found[-1].diameter == pytest.approx(330, rel=0.002)


def beyond_the_rim(scene: np.ndarray = SCENE, frames: int = 20) -> list[np.ndarray]:
    """A still scene at rest, magnified so far that the rim is out of the frame."""
    return [frame(640, seed, scene=scene) for seed in range(frames)]


# The rim leaves the frame in steps of a zoom, so that the last frame before it is out is near.
LEAVING = [frame(d, i) for i, d in enumerate(400 * np.exp(0.02 * np.arange(24)))]


def with_rim_out(*frames: np.ndarray, times: Iterable[float] = ()) -> list[ZoomEstimate]:
    """Estimates of frames that follow upon those of a zoom to where the rim is out."""
    images = [*LEAVING, *frames]
    return list(follow(ZoomFollower(TABLE), images, times))[len(LEAVING) :]


@pytest.mark.parametrize("between", [0, 1, 3])
def test_a_cut_of_the_scene_is_told_and_the_zoom_held_till_a_rim_is_seen(between: int) -> None:
    before, after = beyond_the_rim(), beyond_the_rim(OTHER_SCENE)
    found = with_rim_out(
        *before, *[BLACK] * between, *after, frame(380, 1), frame(380, 2), frame(380, 3)
    )
    told = found[len(before) + 11 : -3]
    assert {e.source for e in found[: len(before)]} == {"tracked"}
    assert found[len(before) - 1].relative_uncertainty < 0.1
    assert {e.source for e in told} == {"held"}
    assert all(e.relative_uncertainty >= 0.3 for e in told)
    assert found[-1].source == "rim"
    assert found[-1].diameter == pytest.approx(380, rel=0.002)


def test_another_scene_is_in_doubt_before_the_cut_is_told() -> None:
    before, after = beyond_the_rim(), beyond_the_rim(OTHER_SCENE)
    found = with_rim_out(*before, *after)
    doubts = [e.relative_uncertainty for e in found[len(before) :]]
    assert all(doubt >= 0.3 for doubt in doubts[1:])


def test_a_picture_that_fills_the_frame_after_a_small_circle_is_in_doubt() -> None:
    images = [frame(300, i) for i in range(10)] + beyond_the_rim()
    found = list(follow(ZoomFollower(TABLE), images))
    assert {e.source for e in found[10:]} == {"held"}
    assert all(e.relative_uncertainty >= 0.3 for e in found[10:])


def lit(image: np.ndarray, gain: float, offset: float) -> np.ndarray:
    return np.clip(image * gain + offset, 0, 255).astype(np.uint8)


@pytest.mark.parametrize(
    "trouble",
    [
        [lit(frame(640, 50), 4.0, 60.0)],
        [lit(frame(640, 50), 0.0, 230.0)] * 3,
        [cv2.blur(frame(640, 50 + i), (1, 41)) for i in range(3)],
        [lit(frame(640, 50 + i), 0.4, 110.0) for i in range(12)],
        [
            cv2.rectangle(frame(640, 50 + i), (40 * i, 0), (40 * i + 150, 360), 120, -1)
            for i in range(9)
        ],
    ],
    ids=["flash", "white", "blur", "smoke", "instrument"],
)
def test_what_passes_is_no_cut(trouble: list[np.ndarray]) -> None:
    found = with_rim_out(*beyond_the_rim(), *trouble, *beyond_the_rim())
    assert found[-1].source == "tracked"
    assert found[-1].relative_uncertainty < 0.1
    assert found[-1].diameter == pytest.approx(found[15].diameter, rel=0.01)


def test_after_a_pause_the_rim_rules_at_once() -> None:
    images = [frame(330, i) for i in range(12)] + [frame(420, i) for i in range(12)]
    times = [i / 25 + 40 * (i >= 12) for i in range(24)]
    found = list(follow(ZoomFollower(TABLE), images, times))
    assert found[12].source == "rim"
    assert [e.diameter for e in found[12:]] == pytest.approx([420.0] * 12, rel=0.002)
    # Without the pause it has to wait for others to agree.
    assert list(follow(ZoomFollower(TABLE), images))[12].source == "held"


@pytest.mark.parametrize("jump", [-100.0, -0.3])
def test_times_that_jump_back_are_those_of_the_next_frame(jump: float) -> None:
    times = [100 + i / 25 + jump * (i >= 15) for i in range(30)]
    images = [frame(330, i) for i in range(30)]
    images[15] = frame(250, 15)
    found = list(follow(ZoomFollower(TABLE), images, times))
    assert [e.diameter for e in found] == pytest.approx([330.0] * 30, rel=0.002)


def test_in_a_pause_with_the_rim_out_the_doubt_grows_as_that_of_held_frames() -> None:
    still = beyond_the_rim()
    held = with_rim_out(*still, *[BLACK] * 100)
    times = [i / 25 for i in range(len(LEAVING + still))]
    once = with_rim_out(*still, BLACK, times=[*times, times[-1] + 4.0])
    assert once[-1].source == "held"
    assert once[-1].relative_uncertainty == pytest.approx(held[-1].relative_uncertainty, rel=0.1)
    # The very frame after the pause may be the first without a rim.
    seen = [frame(330, i) for i in range(12)]
    first = list(follow(ZoomFollower(TABLE), [*seen, BLACK], [*times[:12], 4.5]))
    assert first[-1].relative_uncertainty > 0.15


def test_frames_seconds_apart_are_followed_as_any() -> None:
    images = [frame(330, i) for i in range(20)]
    images[9] = frame(250, 9)
    found = list(follow(ZoomFollower(TABLE), images, [3.0 * i for i in range(20)]))
    assert [e.diameter for e in found] == pytest.approx([330.0] * 20, rel=0.002)
    assert found[9].source == "held"
