"""What files say of the shape of their pixels, as the encoders that are at hand write it."""

from __future__ import annotations

import struct
import zlib
from fractions import Fraction

import av
import cv2
import numpy as np
import pytest

from endocal.files.pixel_shape import stated_pixel_shape

GREY = np.zeros((8, 16), np.uint8)


def with_chunks(data: bytes, *chunks: tuple[bytes, bytes]) -> bytes:
    """A PNG with chunks of its own after the header."""
    more = b"".join(
        struct.pack(">I", len(says)) + kind + says + struct.pack(">I", zlib.crc32(kind + says))
        for kind, says in chunks
    )
    return data[:33] + more + data[33:]


def png(*chunks: tuple[bytes, bytes]) -> bytes:
    return with_chunks(cv2.imencode(".png", GREY)[1].tobytes(), *chunks)


def phys(across: int, down: int, unit: int = 0) -> tuple[bytes, bytes]:
    return b"pHYs", struct.pack(">IIB", across, down, unit)


def by_ffmpeg(codec: str, pixels: str, aspect: Fraction) -> bytes:
    """One frame as FFmpeg's encoder writes it, with that sample aspect ratio."""
    context = av.CodecContext.create(codec, "w")
    assert isinstance(context, av.VideoCodecContext)
    context.width, context.height, context.pix_fmt = 16, 8, pixels
    context.time_base, context.sample_aspect_ratio = Fraction(1, 25), aspect
    frame = av.VideoFrame.from_ndarray(GREY, "gray").reformat(format=pixels)
    frame.pts = 0
    return b"".join(bytes(packet) for packet in [*context.encode(frame), *context.encode()])


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".tif", ".bmp"])
def test_most_files_say_nothing(suffix: str) -> None:
    assert stated_pixel_shape(cv2.imencode(suffix, GREY)[1].tobytes()) is None


@pytest.mark.parametrize(("codec", "pixels"), [("png", "gray"), ("mjpeg", "yuvj420p")])
def test_ffmpegs_stills_say_how_wide_pixels_are(codec: str, pixels: str) -> None:
    assert stated_pixel_shape(by_ffmpeg(codec, pixels, Fraction(16, 15))) == Fraction(16, 15)
    assert stated_pixel_shape(by_ffmpeg(codec, pixels, Fraction(1))) is None


def test_in_tiffs_ffmpeg_says_how_dense_they_are() -> None:
    stated = stated_pixel_shape(by_ffmpeg("tiff", "gray", Fraction(16, 15)))
    # Dots per inch across over those down: one over the pixel's width over its height.
    assert stated == Fraction(15, 16)


@pytest.mark.parametrize("order", ["<", ">"])
def test_bigtiffs_hold_a_resolution_in_its_entry(order: str) -> None:
    mark = b"II+\0" if order == "<" else b"MM\0+"
    start = mark + struct.pack(order + "HHQ", 8, 0, 16)
    entries = [
        struct.pack(order + "HHQII", tag, 5, 1, dpi, 1) for tag, dpi in ((282, 96), (283, 72))
    ]
    data = start + struct.pack(order + "Q", 2) + b"".join(entries) + bytes(8)
    assert stated_pixel_shape(data) == Fraction(4, 3)


@pytest.mark.parametrize(
    ("across", "down"), [(2835, 2835), (2834, 2835), (0, 0), (0, 3), (3, 0), (1, 1000), (1000, 1)]
)
def test_equal_numbers_and_nonsense_say_nothing(across: int, down: int) -> None:
    assert stated_pixel_shape(png(phys(across, down, unit=1))) is None


@pytest.mark.parametrize("place", [1_000_000, 2**31, 2**32 - 8, 2**32 - 1])
def test_a_resolution_that_is_not_in_the_file_says_nothing(place: int) -> None:
    entry = struct.pack("<HHII", 282, 5, 1, place)
    data = b"II*\0" + struct.pack("<IH", 8, 1) + entry + bytes(4)
    assert stated_pixel_shape(data) is None


def test_a_jfif_segment_that_is_too_short_says_nothing() -> None:
    whole = by_ffmpeg("mjpeg", "yuvj420p", Fraction(16, 15))
    at = whole.index(b"JFIF") - 4
    (length,) = struct.unpack_from(">H", whole, at + 2)
    short = whole[: at + 2] + struct.pack(">H", 7) + b"JFIF\0" + whole[at + 2 + length :]
    assert stated_pixel_shape(short) is None


def test_what_is_cut_short_says_nothing() -> None:
    assert stated_pixel_shape(png((b"pHYs", b"\0\0\0\1"))) is None
    assert stated_pixel_shape(png(phys(16, 15))[:40]) is None
