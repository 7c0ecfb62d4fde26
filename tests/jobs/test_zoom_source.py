"""What a followed zoom's centre goes by: the circle's shift, seen or recorded, or the table alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from endocal.errors import InputError
from endocal.jobs.zoom_log import RecordedZoom
from endocal.jobs.zoom_source import FollowedZoom
from endocal.zoom.table import Setting, ZoomTable

MIDDLE = (319.5, 239.5)
BARE = ZoomTable(tuple(Setting(-1.3 / d**2, MIDDLE, d) for d in (400.0, 500.0)), (640, 480))
BLACK = np.zeros((480, 640), np.uint8)


def recorded(folder: Path, shift: tuple[float, float]) -> RecordedZoom:
    path = folder / "zoom.csv"
    path.write_text(f"frame,diameter,shift_x,shift_y\n0,450,{shift[0]},{shift[1]}\n")
    return RecordedZoom(str(path))


@pytest.mark.parametrize("center", ["auto", "follow"])
def test_a_recorded_shift_moves_the_centre(tmp_path: Path, center: str) -> None:
    zoom = FollowedZoom(BARE, "auto", center, None, recorded(tmp_path, (6.0, -4.0)), None, None)
    assert zoom.model(lambda: BLACK, None).center == pytest.approx((325.5, 235.5))
    assert not zoom.notes


def test_a_fixed_centre_takes_no_recorded_shift_even_a_wild_one(tmp_path: Path) -> None:
    for shift in ((6.0, -4.0), (5000.0, 0.0)):
        zoom = FollowedZoom(BARE, "auto", "fixed", None, recorded(tmp_path, shift), None, None)
        assert zoom.model(lambda: BLACK, None).center == pytest.approx(MIDDLE)


@pytest.mark.parametrize("shift", [(321.0, 0.0), (0.0, -241.0)])
def test_a_recorded_shift_of_half_the_frame_is_refused_with_its_line(
    tmp_path: Path, shift: tuple[float, float]
) -> None:
    with pytest.raises(InputError, match=r"zoom\.csv, line 2: the shift .* half the 640x480 frame"):
        FollowedZoom(BARE, "auto", "auto", None, recorded(tmp_path, shift), None, None)


def test_a_centre_that_is_to_follow_needs_the_places_of_all_circles() -> None:
    half = ZoomTable(
        (BARE.settings[0], Setting(-1.3 / 500**2, MIDDLE, 500.0, circle=MIDDLE)), BARE.size
    )
    words = r"--center follow: .* at 400 px; make the table"
    with pytest.raises(InputError, match=words):
        FollowedZoom(half, "auto", "follow", None, None, None, None)


def test_a_table_without_them_is_followed_and_that_is_said_once() -> None:
    zoom = FollowedZoom(BARE, "auto", "auto", 450.0, None, None, None)
    for _ in range(3):
        assert zoom.model(lambda: BLACK, None).center == pytest.approx(MIDDLE)
    (note,) = zoom.notes
    assert "does not tell where its circles are" in note
    assert not FollowedZoom(BARE, "auto", "fixed", 450.0, None, None, None).notes


def test_a_look_up_by_area_needs_the_areas_from_the_start() -> None:
    with pytest.raises(InputError, match=r"--lookup area: .* 400 px and 500 px has no area"):
        FollowedZoom(BARE, "area", "fixed", 450.0, None, None, None)
