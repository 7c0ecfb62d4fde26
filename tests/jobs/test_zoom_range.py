"""A zoom that is recorded or assumed: how it is looked up, and what is said of one beyond the table."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from endocal.errors import InputError, UsageError
from endocal.jobs.zoom_log import RecordedZoom
from endocal.jobs.zoom_source import FollowedZoom
from endocal.zoom.table import Setting, ZoomTable

MIDDLE = (319.5, 239.5)
TABLE = ZoomTable(
    tuple(Setting(-1.3 / d**2, MIDDLE, d, circle=MIDDLE) for d in (400.0, 500.0)), (640, 480)
)
# The centre runs away with the zoom.
RUNAWAY = ZoomTable(
    (Setting(-1.3 / 400**2, MIDDLE, 400.0), Setting(-1.3 / 500**2, (360, 239.5), 500.0)), (640, 480)
)


def follow(folder: Path, diameters: list[float], lookup: str = "auto") -> FollowedZoom:
    path = folder / "zoom.csv"
    rows = [f"{i},{i / 25},{d}" for i, d in enumerate(diameters)]
    path.write_text("\n".join(["frame,time,diameter", *rows]) + "\n")
    zoom = FollowedZoom(TABLE, lookup, "auto", None, RecordedZoom(str(path)), None, None)
    for i in range(len(diameters)):
        zoom.model(lambda: np.zeros((480, 640), np.uint8), i / 25)
    return zoom


def test_within_the_table_there_is_nothing_to_say(tmp_path: Path) -> None:
    zoom = follow(tmp_path, [400.0, 450.0, 500.0, 505.0, 395.0])
    assert not zoom.notes
    assert zoom.diameters == pytest.approx((395.0, 505.0))


def test_beyond_it_the_law_is_named_once(tmp_path: Path) -> None:
    (note,) = follow(tmp_path, [450.0, 500.0, 560.0, 600.0, 450.0, 300.0]).notes
    assert "560 px" in note
    assert "0.08 s" in note
    assert "400 to 500 px" in note


def test_a_record_tells_no_area_and_is_looked_up_by_diameter(tmp_path: Path) -> None:
    (note,) = follow(tmp_path, [450.0], "area").notes
    assert "no areas" in note
    assert not follow(tmp_path, [450.0], "diameter").notes


@pytest.mark.parametrize("lookup", ["auto", "diameter", "area"])
@pytest.mark.parametrize("diameter", [1e-3, 90.0, 3300.0, 1e5, 1e300])
def test_an_assumed_diameter_that_cannot_be_is_refused_at_once(
    lookup: str, diameter: float
) -> None:
    with pytest.raises(
        UsageError, match=r"--assume-diameter .*640x480 .*400 to 500 px.*100 to 3200"
    ):
        FollowedZoom(TABLE, lookup, "auto", diameter, None, None, None)


@pytest.mark.parametrize("diameter", [101.0, 450.0, 3100.0])
def test_one_far_beyond_the_frame_is_not(diameter: float) -> None:
    zoom = FollowedZoom(TABLE, "auto", "auto", diameter, None, None, None)
    model = zoom.model(lambda: np.zeros((480, 640), np.uint8), 0.0)
    assert model.lam * diameter**2 == pytest.approx(-1.3)
    assert zoom.sources == {"given": 1}


def test_one_that_the_table_cannot_tell_a_lens_for_is_refused_at_once() -> None:
    with pytest.raises(UsageError, match=r"--assume-diameter 3100: .*400 to 500 px"):
        FollowedZoom(RUNAWAY, "auto", "auto", 3100.0, None, None, None)


@pytest.mark.parametrize("diameter", [9.0, 99.0, 3300.0])
def test_a_recorded_diameter_that_cannot_be_is_refused_with_its_line(
    tmp_path: Path, diameter: float
) -> None:
    words = (
        rf"zoom\.csv, line 3: the diameter {diameter:g} px .*640x480 .*400 to 500 px.*100 to 3200"
    )
    with pytest.raises(InputError, match=words):
        follow(tmp_path, [450.0, diameter])


def test_a_recorded_one_that_the_table_cannot_tell_a_lens_for_is_refused_with_its_line(
    tmp_path: Path,
) -> None:
    path = tmp_path / "zoom.csv"
    path.write_text("frame,diameter\n0,450\n1,3100\n")
    with pytest.raises(InputError, match=r"zoom\.csv, line 3: the centre .* correct the row"):
        FollowedZoom(RUNAWAY, "auto", "auto", None, RecordedZoom(str(path)), None, None)
