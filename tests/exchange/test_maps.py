"""Maps take other tools to the picture that endocal makes."""

from __future__ import annotations

import io

import cv2
import numpy as np
import pytest

from endocal.exchange import maps
from endocal.model import DivisionModel
from endocal.remap.geometry import output_geometry
from endocal.remap.remapper import Remapper
from tests.exchange import lenses


def smooth(size: tuple[int, int]) -> np.ndarray:
    """A grey picture whose neighbours differ by 1.5 levels at most."""
    x, y = np.meshgrid(np.arange(size[0]), np.arange(size[1]))
    return np.round(128 + 60 * np.sin(x / 60) * np.cos(y / 55) + 30 * np.sin((x + y) / 90)).astype(
        np.uint8
    )


@pytest.fixture(params=["same", "crop"])
def case(request):
    model, _ = lenses.endoscope()
    geometry = output_geometry([model], None, request.param)
    return model, geometry, Remapper(model, device="numpy", view=request.param)


def interior(x: np.ndarray, y: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    return (x >= 1) & (x <= size[0] - 2) & (y >= 1) & (y <= size[1] - 2)


def test_npz_through_opencv(case) -> None:
    model, geometry, remapper = case
    x, y = maps.source_maps(model, geometry)
    data = maps.npz_maps(x, y, model)
    stored = np.load(io.BytesIO(data))
    assert tuple(stored["source_size"]) == model.size
    assert stored["map_x"].dtype == stored["map_y"].dtype == np.float32
    picture = smooth(model.size)
    theirs = cv2.remap(picture, stored["map_x"], stored["map_y"], cv2.INTER_LINEAR)
    ours = remapper.apply(picture)
    gap = np.abs(theirs.astype(int) - ours)[interior(x, y, model.size)]
    # Both round once; OpenCV before 5 also rounds the place to 1/32 px.
    assert gap.max() <= 1
    assert maps.npz_maps(x, y, model) == data


@pytest.mark.parametrize(("depth", "accuracy"), [(32, 1e-4), (16, 0.5 / 65535)])
def test_stmap_as_its_readers_define_it(case, depth: int, accuracy: float) -> None:
    model, geometry, _ = case
    x, y = maps.source_maps(model, geometry)
    data = maps.stmap_tiff(x, y, model.size, depth)
    stored = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    assert stored.dtype == (np.float32 if depth == 32 else np.uint16)
    scale = 1.0 if depth == 32 else 65535.0
    blue, green, red = np.moveaxis(stored / scale, -1, 0)
    w, h = model.size
    # Fractions of the frame from its lower left corner; half a pixel from corner to centre.
    there = (red * w - 0.5, (1 - green) * h - 0.5)
    inside = interior(x, y, model.size)
    step = accuracy if depth == 32 else accuracy * max(w, h)
    for found, wanted in zip(there, (x, y), strict=True):
        assert np.abs(found - wanted)[inside].max() <= step * 1.01
    assert (blue[inside] == 1).all()
    outside = (x < -0.5) | (x > w - 0.5) | (y < -0.5) | (y > h - 0.5) | np.isnan(x)
    assert (blue[outside] == 0).all()


def test_a_model_without_distortion_maps_each_pixel_to_itself() -> None:
    model = DivisionModel(0.0, (10.0, 8.0), (24, 16))
    x, y = maps.source_maps(model, output_geometry([model]))
    columns, rows = np.meshgrid(np.arange(24), np.arange(16))
    assert np.array_equal(x, columns)
    assert np.array_equal(y, rows)
    for data, whole in zip(maps.pgm_maps(x, y, model.size), (columns, rows), strict=True):
        stored = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
        assert stored.dtype == np.uint16
        assert np.array_equal(stored, whole)


def test_what_shows_nothing_is_unmapped() -> None:
    # A pincushion's corners have no source; a small view of a barrel's has it outside the frame.
    model = DivisionModel(4e-5, (50.0, 40.0), (100, 80))
    x, y = maps.source_maps(model, output_geometry([model], scale=2.0, view="full"))
    outside = ~((x >= -0.5) & (x < 99.5) & (y >= -0.5) & (y < 79.5))
    assert outside.any()
    assert not outside.all()
    for data in maps.pgm_maps(x, y, model.size):
        stored = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
        assert np.array_equal(stored == 0xFFFF, outside)
