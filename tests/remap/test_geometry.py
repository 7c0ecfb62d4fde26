"""Views: what of the undistorted scene an output shows."""

from __future__ import annotations

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings

from endocal.boundary.circle import Boundary
from endocal.errors import InputError, UsageError
from endocal.model import DivisionModel
from endocal.remap.geometry import MAX_SIDE, VIEWS, output_geometry

SIZE = (320, 240)
BARREL = DivisionModel(-9e-6, (150.0, 126.0), SIZE)
PINCUSHION = DivisionModel(3e-6, (150.0, 126.0), SIZE)
CIRCLE = Boundary((165.0, 118.0), 200.0, 31000.0, 1.0)


def shown(geometry):
    """The undistorted place of every output pixel, (h, w, 2)."""
    i, j = np.meshgrid(np.arange(geometry.size[0]), np.arange(geometry.size[1]))
    return np.stack([i, j], axis=-1) * geometry.step + geometry.origin


def has_blank(geometry, model, circle=None, places=None):
    places = shown(geometry) if places is None else places
    x, y = np.moveaxis(model.distort(places), -1, 0)
    slack = 2e-6  # px: the geometry is rounded
    inside = (x >= -slack) & (x <= model.size[0] - 1 + slack)
    inside &= (y >= -slack) & (y <= model.size[1] - 1 + slack)
    if circle is not None:
        inside &= (
            np.hypot(x - circle.center[0], y - circle.center[1]) <= circle.diameter / 2 + slack
        )
    return not inside.all()


@given(st.floats(-200, 500), st.floats(-200, 400), st.integers(1, 400), st.integers(1, 300))
@settings(max_examples=30)
def test_without_distortion_every_view_is_the_frame(cx, cy, w, h):
    center = (np.clip(cx, -w, 2 * w), np.clip(cy, -h, 2 * h))
    model = DivisionModel(0.0, center, (w, h))
    for view in VIEWS:
        geometry = output_geometry([model], view=view)
        assert (geometry.size, geometry.origin) == ((w, h), (0, 0))
        assert geometry.step == (1, 1) or min(w, h) == 1


@pytest.mark.parametrize("model", [BARREL, PINCUSHION])
@pytest.mark.parametrize("circle", [None, CIRCLE])
@pytest.mark.parametrize("size", [None, (200, 300), (641, 360)])
def test_a_crop_holds_no_blank_pixel_and_cannot_grow(model, circle, size):
    geometry = output_geometry([model], [circle], "crop", size)
    assert geometry.step[0] == geometry.step[1]
    assert not has_blank(geometry, model, circle)
    # No rectangle of this shape, 1 % larger, fits anywhere near.
    w, h = geometry.size
    step = geometry.step[0] * 1.01
    middle = np.add(geometry.origin, np.multiply(geometry.step, (w - 1, h - 1)) / 2)
    for dx in np.linspace(-12, 12, 9):
        for dy in np.linspace(-12, 12, 9):
            origin = middle + np.array([dx, dy]) - step * np.array([w - 1, h - 1]) / 2
            larger = type(geometry)(SIZE, geometry.size, tuple(origin), (step, step))
            corners_and_sides = shown(larger)[:: (h - 1), :], shown(larger)[:, :: (w - 1)]
            assert any(has_blank(larger, model, circle, p) for p in corners_and_sides), (dx, dy)


@pytest.mark.parametrize("model", [BARREL, PINCUSHION])
@pytest.mark.parametrize("circle", [None, CIRCLE])
def test_a_full_view_holds_all_content_and_no_more(model, circle):
    geometry = output_geometry([model], [circle], "full")
    i, j = np.meshgrid(np.arange(SIZE[0]), np.arange(SIZE[1]))
    content = np.stack([i, j], axis=-1).reshape(-1, 2).astype(float)
    if circle is not None:
        content = content[np.hypot(*(content - circle.center).T) <= circle.diameter / 2]
    places = (model.undistort(content) - geometry.origin) / geometry.step
    assert places.min() > -1e-4
    assert (places <= np.array(geometry.size) - 1 + 1e-4).all()
    margins = [places.min(axis=0), np.array(geometry.size) - 1 - places.max(axis=0)]
    # Content touches both sides of one axis; of a circle, whose outermost pixel lies up to one within it,
    # as near as that pixel is large in the output.
    near = 0.01 if circle is None else 1.5 / geometry.step[0]
    assert any(max(margins[0][k], margins[1][k]) < near for k in (0, 1))


def test_one_geometry_serves_every_model():
    models = [BARREL, DivisionModel(-3e-6, (160.0, 120.0), SIZE), PINCUSHION]
    crop = output_geometry(models, view="crop")
    assert not any(has_blank(crop, m) for m in models)
    full = output_geometry(models, view="full")
    singles = [output_geometry([m], view="full") for m in models]
    assert full.step[0] >= max(g.step[0] for g in singles)


def test_sizes_scale_the_view_and_never_stretch_it():
    half = output_geometry([BARREL], scale=0.5)
    assert (half.size, half.step, half.origin) == ((160, 120), (2, 2), (0.5, 0.5))
    wide = output_geometry([BARREL], size=(640, 240))
    # A wider shape shows more to both sides; the view's middle stays in the middle.
    assert (wide.step, wide.origin) == ((1, 1), (-160, 0))


def test_square_pixels_widen_the_output():
    model = DivisionModel(-9e-6, (150.0, 126.0), SIZE, pixel_aspect=1.5)
    square = output_geometry([model], square_pixels=True)
    assert (square.size, square.pixel_aspect) == ((480, 240), 1.0)
    assert square.step == pytest.approx((2 / 3, 1), abs=1e-9)
    kept = output_geometry([model])
    assert (kept.size, kept.pixel_aspect, kept.step) == (SIZE, 1.5, (1, 1))


def test_what_makes_no_sense_is_refused():
    with pytest.raises(UsageError, match="view 'wide'"):
        output_geometry([BARREL], view="wide")
    with pytest.raises(UsageError, match="exclude each other"):
        output_geometry([BARREL], size=(10, 10), scale=2)
    for scale in (0.0, -1.0, float("nan"), float("inf")):
        with pytest.raises(UsageError):
            output_geometry([BARREL], scale=scale)
    for size in ((0, 10), (10, MAX_SIDE + 1)):
        with pytest.raises(UsageError, match=f"{MAX_SIDE} px a side"):
            output_geometry([BARREL], size=size)
    with pytest.raises(UsageError, match="at least one model"):
        output_geometry([])
    with pytest.raises(InputError, match="different sizes"):
        output_geometry([BARREL, BARREL.rescale((640, 480))])
    folding = DivisionModel(-1.2e-4, (160.0, 120.0), SIZE)  # its pole lies within the frame
    with pytest.raises(InputError, match="no bounds"):
        output_geometry([folding], view="full")
