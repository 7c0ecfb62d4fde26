"""The circle's shift on the sensor: followed, deaf to one false circle, and still when it stands still."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from endocal.benchmarks.zoom import follow_clip, loose_clip, table_of
from endocal.boundary.circle import Boundary
from endocal.boundary.detect import Located
from endocal.synth.clip import clip_frames
from endocal.synth.lens import typical_lens
from endocal.synth.motion import CouplerPlay
from endocal.zoom.follow import FollowSpec, ZoomFollower
from endocal.zoom.shift import CircleShift
from endocal.zoom.table import Setting, ZoomTable

DIAMETER = 600.0
CIRCLE = (640.0, 350.0)
# The circle's centre drifts with the zoom, and lies beside the distortion centre.
TABLE = ZoomTable(
    tuple(
        Setting(-1.3 / d**2, (630.0, 360.0), d, circle=(CIRCLE[0] + (d - DIAMETER) / 10, CIRCLE[1]))
        for d in (500.0, 600.0, 800.0)
    ),
    (1280, 720),
)


def located(x: float, y: float, diameter: float = DIAMETER, sigma: float = 0.05) -> Located:
    """A circle that lies (x, y) px from where the table has it."""
    place = TABLE.circle_at(diameter)
    assert place is not None
    return Located(Boundary((place[0] + x, place[1] + y), diameter, 1e5, 1.0), 2 * sigma, sigma)


def follow(shift: CircleShift, places: list[tuple[float, float]]) -> list[tuple[float, float]]:
    shown = []
    for x, y in places:
        shift.advance(1.0)
        shift.measure(located(x, y), DIAMETER)
        shown.append(shift.value)
    return shown


@given(
    x=st.floats(-15, 15),
    y=st.floats(-15, 15),
    diameter=st.floats(450, 900),
)
def test_the_first_circle_tells_the_shift_at_any_zoom(x: float, y: float, diameter: float) -> None:
    shift = CircleShift(TABLE.circle_at)
    shift.measure(located(x, y, diameter), diameter)
    # What is less than it can be known to is none.
    assert math.dist(shift.value, (x, y)) <= 1e-9 or math.hypot(x, y) <= 0.2


def test_a_still_circle_moves_nothing() -> None:
    noise = np.random.default_rng(3).normal(0, 0.05, (200, 2))
    shown = follow(CircleShift(TABLE.circle_at), [(4 + dx, -3 + dy) for dx, dy in noise.tolist()])
    assert len(set(shown)) <= 6
    assert math.dist(shown[-1], (4, -3)) < 0.15


@pytest.mark.parametrize("speed", [0.05, 0.5, 1.5, 2.8])
def test_a_wandering_circle_is_followed_without_lag(speed: float) -> None:
    places = [(speed * max(i - 20, 0), 0.0) for i in range(80)]
    shown = follow(CircleShift(TABLE.circle_at), places)
    errors = [math.dist(a, b) for a, b in zip(shown, places, strict=True)]
    # Where it sets in at full speed, three measurements have to agree.
    assert max(errors[25:]) <= 0.2
    assert max(errors) <= max(2.1 * speed, 0.2)


@pytest.mark.parametrize("count", [1, 2])
def test_false_circles_move_nothing(count: int) -> None:
    places = [(1.0, 1.0)] * 20 + [(40.0, -25.0)] * count + [(1.0, 1.0)] * 20
    shown = follow(CircleShift(TABLE.circle_at), places)
    assert all(math.dist(s, (1.0, 1.0)) < 0.2 for s in shown)


def test_a_jolt_is_believed_when_three_agree() -> None:
    shown = follow(CircleShift(TABLE.circle_at), [(0.0, 0.0)] * 20 + [(9.0, 5.0)] * 5)
    assert shown[21] == shown[19]
    assert shown[22] == pytest.approx((9.0, 5.0))


def test_an_arc_that_tells_another_diameter_tells_little_of_the_centre() -> None:
    """Of a circle that is cut on three sides, centre and diameter are off together."""
    shift = CircleShift(TABLE.circle_at)
    follow(shift, [(0.0, 0.0)] * 20)
    for _ in range(3):
        shift.advance(1.0)
        wide = located(8.0, 0.0)
        boundary = replace(wide.boundary, diameter=DIAMETER + 16)
        shift.measure(wide._replace(boundary=boundary), DIAMETER)
    assert math.hypot(*shift.value) < 1.0


def test_a_table_that_tells_no_circles_has_no_shift() -> None:
    bare = ZoomTable(tuple(replace(s, circle=None) for s in TABLE.settings), TABLE.size)
    assert bare.circle_at(DIAMETER) is None
    shift = CircleShift(bare.circle_at)
    shift.measure(located(5.0, 5.0), DIAMETER)
    assert shift.value == (0.0, 0.0)


def test_the_distortion_centre_goes_with_a_scope_that_is_loose_in_its_coupler(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # The benchmark's lens before half as large a sensor, which is drawn in a fraction of the time.
    clip = replace(
        loose_clip(4, seconds=2.0),
        lens=typical_lens((640, 360), fill=1.0),
        play=CouplerPlay((9.0, 5.4), period=4.0),
    )
    frames = list(clip_frames(clip))
    # Drawn once, and followed twice.
    monkeypatch.setattr("endocal.benchmarks.zoom.clip_frames", lambda _: frames)
    followed, _ = follow_clip("followed", clip)
    table, _ = follow_clip("table", clip, spec=FollowSpec(follows_shift=False))
    assert table.visible_center[0] > 3
    assert followed.visible_center[0] < 0.15
    assert followed.visible_center[1] < 1.0
    assert followed.visible_error == table.visible_error, "the zoom is the same"


def test_out_of_sight_the_last_shift_holds() -> None:
    lens = typical_lens((1280, 720), fill=1.0)
    moved = lens.shifted((11.0, -7.0))
    frames = list(clip_frames(replace(loose_clip(4, 0.4), lens=moved, play=CouplerPlay())))
    follower = ZoomFollower(table_of(lens))
    for frame in frames:
        estimate = follower.update(frame.image[..., 1], float(frame.time))
    assert estimate.shift == pytest.approx((11.0, -7.0), abs=0.3)
    dark = follower.update(np.full((720, 1280), 20, np.uint8), 0.44)
    assert dark.boundary is None
    assert dark.shift == estimate.shift
