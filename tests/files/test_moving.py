"""Files that begin like a picture and go on: told from pictures with something behind them."""

from __future__ import annotations

import struct
import zlib

import cv2
import numpy as np
import pytest

from endocal.files.moving import is_moving


def jpeg(seed: int = 0, size: tuple[int, int] = (300, 200)) -> bytes:
    noise = np.random.default_rng(seed).integers(0, 255, (size[1], size[0], 3), dtype=np.uint8)
    return cv2.imencode(".jpg", noise)[1].tobytes()


def moving(data: bytes) -> bool:
    return is_moving(lambda size: data[:size])


def chunk(kind: bytes, body: bytes) -> bytes:
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def png(frames: int | None) -> bytes:
    data = cv2.imencode(".png", np.zeros((20, 30), np.uint8))[1].tobytes()
    head = 8 + 25  # the signature and IHDR
    control = b"" if frames is None else chunk(b"acTL", struct.pack(">II", frames, 0))
    return data[:head] + control + data[head:]


def test_motion_jpeg() -> None:
    """Longer than what is looked at first, so that more has to be asked for."""
    assert len(jpeg()) > 1 << 16
    assert moving(jpeg(0) + jpeg(1))
    assert not moving(jpeg())


@pytest.mark.parametrize(
    "behind", [b"", b"\0" * 30, b"\xff\xd8", b"\xff\xd8\xff", jpeg(1, (64, 48))]
)
def test_a_jpeg_with_something_behind_it(behind: bytes) -> None:
    """Padding, or a thumbnail."""
    assert not moving(jpeg() + behind)


def test_a_jpeg_that_says_that_the_other_one_belongs_to_it() -> None:
    first = jpeg()
    marker = b"\xff\xe2" + struct.pack(">H", 2 + 8) + b"MPF\0II*\0"
    assert not moving(first[:2] + marker + first[2:] + jpeg(1))


@pytest.mark.parametrize("share", [0.01, 0.5, 0.99])
def test_what_is_broken_is_left_to_the_picture_reader(share: float) -> None:
    whole = jpeg()
    assert not moving(whole[: int(len(whole) * share)])
    assert not moving(whole[:20] + bytes(50) + whole[70:])


def test_an_animated_png() -> None:
    assert moving(png(25))
    assert not moving(png(1))
    assert not moving(png(None))
    assert not moving(png(25)[:30])
