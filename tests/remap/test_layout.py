"""Planes of pixel formats: shapes, depth, black, and where chroma samples lie."""

from __future__ import annotations

import numpy as np
import pytest

from endocal.errors import InputError
from endocal.remap.layout import frame_layout, supported


def planes(pix_fmt, size=(7, 5), full_range=False, **options):
    return frame_layout(pix_fmt, size, full_range=full_range, **options).planes


@pytest.mark.parametrize(
    ("pix_fmt", "shapes"),
    [
        ("yuv420p", [(5, 7), (3, 4), (3, 4)]),
        ("yuv422p10le", [(5, 7), (5, 4), (5, 4)]),
        ("yuv444p12le", [(5, 7)] * 3),
        ("yuv411p", [(5, 7), (5, 2), (5, 2)]),
        ("yuva420p", [(5, 7), (3, 4), (3, 4), (5, 7)]),
        ("gray", [(5, 7)]),
        ("nv12", [(5, 7), (3, 8)]),
        ("nv24", [(5, 7), (5, 14)]),
        ("p010le", [(5, 7), (3, 8)]),
        ("p210le", [(5, 7), (5, 8)]),
        ("rgb24", [(5, 21)]),
        ("bgra", [(5, 28)]),
        ("rgb48le", [(5, 21)]),
        ("gbrp10le", [(5, 7)] * 3),
    ],
)
def test_planes_have_the_shapes_that_ffmpeg_gives_them(pix_fmt, shapes):
    assert [p.shape for p in planes(pix_fmt)] == shapes


@pytest.mark.parametrize(
    ("pix_fmt", "full", "fills"),
    [
        ("yuv420p", False, [(16,), (128,), (128,)]),
        ("yuv420p", True, [(0,), (128,), (128,)]),
        ("yuvj420p", False, [(0,), (128,), (128,)]),
        ("yuv420p10le", False, [(64,), (512,), (512,)]),
        ("yuv422p12le", True, [(0,), (2048,), (2048,)]),
        ("gray12le", False, [(256,)]),
        ("nv12", False, [(16,), (128, 128)]),
        ("p010le", False, [(64,), (512, 512)]),
        ("rgb24", False, [(0, 0, 0)]),
        ("argb", True, [(255, 0, 0, 0)]),
        ("gbrap", True, [(0,), (0,), (0,), (255,)]),
        ("yuva444p10le", False, [(64,), (512,), (512,), (1023,)]),
    ],
)
def test_black_is_in_the_streams_own_range(pix_fmt, full, fills):
    assert [p.fill for p in planes(pix_fmt, full_range=full)] == fills


@pytest.mark.parametrize(
    ("location", "origin"),
    [
        ("left", (0, 0.5)),
        ("center", (0.5, 0.5)),
        ("topleft", (0, 0)),
        ("top", (0.5, 0)),
        ("bottomleft", (0, 1)),
        ("bottom", (0.5, 1)),
        ("unspecified", (0, 0.5)),
    ],
)
def test_chroma_samples_lie_where_the_location_says(location, origin):
    assert planes("yuv420p", chroma_location=location)[1].origin == origin
    # 4:2:2 has a chroma sample in every row: only the horizontal place remains.
    assert planes("yuv422p", chroma_location=location)[1].origin == (origin[0], 0)
    assert planes("yuv444p", chroma_location=location)[1].origin == (0, 0)


def test_upper_bits_count_in_p010():
    luma = planes("p010le")[0]
    assert (luma.depth, luma.shift, luma.maximum, luma.dtype) == (10, 6, 1023, np.uint16)


@pytest.mark.parametrize(
    "pix_fmt", ["yuyv422", "pal8", "gray16be", "yuv420p10be", "rgb", "xyz12le"]
)
def test_an_unknown_format_is_refused_by_name(pix_fmt):
    assert not supported(pix_fmt)
    with pytest.raises(InputError, match=pix_fmt):
        planes(pix_fmt)


def test_nonsense_is_refused():
    with pytest.raises(InputError, match="chroma location 'middle'"):
        planes("yuv420p", chroma_location="middle")
    with pytest.raises(InputError, match="0x5"):
        planes("yuv420p", (0, 5))
