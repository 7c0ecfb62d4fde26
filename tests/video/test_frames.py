"""Views of planes and the pool."""

from __future__ import annotations

import av
import numpy as np
import pytest

from endocal.remap.layout import frame_layout
from endocal.video.frames import FramePool, plane_views

FORMATS = (
    *(
        "yuv420p",
        "yuv422p",
        "yuv444p",
        "yuv411p",
        "yuv440p",
        "yuvj420p",
        "yuva420p",
        "nv12",
        "nv16",
    ),
    *("yuv420p10le", "yuv422p12le", "yuv444p16le", "p010le", "gray", "gray10le", "gray16le"),
    *("rgb24", "bgr24", "bgra", "argb", "bgr0", "gbrp", "gbrap", "gbrp12le", "rgb48le", "bgra64le"),
)


@pytest.mark.parametrize("pix_fmt", FORMATS)
@pytest.mark.parametrize("size", [(66, 34), (67, 35)])
def test_views_have_the_shape_of_the_layout(pix_fmt: str, size: tuple[int, int]) -> None:
    views = plane_views(av.VideoFrame(*size, pix_fmt))
    layout = frame_layout(pix_fmt, size, full_range=False)
    assert [v.shape for v in views] == [p.shape for p in layout.planes]
    assert [v.dtype for v in views] == [p.dtype for p in layout.planes]


def test_writing_into_a_view_writes_into_the_frame() -> None:
    frame = av.VideoFrame(66, 34, "yuv420p10le")
    for i, view in enumerate(plane_views(frame)):
        view[...] = 100 + i
    for i, plane in enumerate(frame.planes):
        rows = np.frombuffer(bytes(plane), np.uint16).reshape(plane.height, -1)
        assert (rows[:, : plane.width] == 100 + i).all()


def test_the_pool_hands_out_a_frame_again() -> None:
    pool = FramePool((64, 48), "yuv420p")
    frame = pool.take()
    pool.give_back(frame)
    assert pool.take() is frame
    assert pool.take() is not frame


def test_a_frame_that_an_encoder_still_reads_is_not_overwritten() -> None:
    """A filter graph that buffers frames stands for such an encoder."""
    pool = FramePool((64, 48), "gray")
    frame = pool.take()
    plane_views(frame)[0][...] = 7
    frame.pts = 0
    graph = av.filter.Graph()
    source = graph.add_buffer(width=64, height=48, format=av.VideoFormat("gray"), time_base=1)
    graph.link_nodes(source, graph.add("buffersink")).configure()
    graph.vpush(frame)
    pool.give_back(frame)
    plane_views(pool.take())[0][...] = 9
    assert (plane_views(graph.vpull())[0] == 7).all()
