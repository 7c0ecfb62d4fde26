"""Panels beside the picture are told from it by their straight edge."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from endocal.benchmarks.rim_frames import random_rim_frame
from endocal.boundary.coarse import thin
from endocal.boundary.detect import find_boundary
from endocal.boundary.frame import frame_of
from endocal.boundary.outside import darkest_corner
from endocal.boundary.panel import picture_between_panels

SIZE = (720, 540)


def panels_leave(image: NDArray[np.uint8]) -> tuple[slice, slice] | None:
    frame = frame_of(image, 1.0)
    return picture_between_panels(thin(frame), darkest_corner(frame).contrast)


@pytest.mark.parametrize("level", [25, 90, 230])
@pytest.mark.parametrize("where", ["left", "right", "top", "both"])
def test_the_circle_beside_a_panel_is_that_of_the_picture_alone(level: int, where: str) -> None:
    frame = random_rim_frame(3, "instruments", SIZE)
    alone = find_boundary(frame.image)
    assert alone is not None
    wide = {"left": [(0, 0), (200, 0)], "right": [(0, 0), (0, 200)], "top": [(150, 0), (0, 0)]}
    pads = wide.get(where, [(0, 0), (120, 90)])
    found = find_boundary(np.pad(frame.image, pads, constant_values=level))
    assert found is not None
    x, y = alone.center
    # The picture is thinned at other pixels, so that the way to the rim is another.
    assert found.center == pytest.approx((x + pads[1][0], y + pads[0][0]), abs=0.1)
    assert found.diameter == pytest.approx(alone.diameter, abs=0.1)
    assert found.area == pytest.approx(alone.area, rel=1e-3)


@pytest.mark.parametrize("trouble", ["plain", "logos", "cut 2 sides", "cut 4 sides"])
def test_a_picture_alone_has_no_panel(trouble: str) -> None:
    for seed in range(4):
        assert panels_leave(random_rim_frame(seed, trouble).image) is None


@pytest.mark.parametrize("turned", [False, True])
def test_edges_through_the_middle_leave_no_picture(turned: bool) -> None:
    striped = np.zeros((540, 720), np.uint8)
    striped[:, 330:390:20] = 200
    striped[:, 340:400:20] = 90
    image = np.ascontiguousarray(striped.T) if turned else striped
    assert panels_leave(image) is None
    assert find_boundary(image) is None


def test_a_scene_that_varies_everywhere_has_no_panel() -> None:
    x = np.arange(720)
    ramp = np.tile(np.clip((x - 400) * 0.8, 0, 255), (540, 1)).astype(np.uint8)
    assert panels_leave(ramp) is None
