"""Damage in the middle of a TIFF: refused in the decoder's words; odd tags and lost pages are no damage."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator

import cv2
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from endocal.errors import InputError
from endocal.files import decode_image
from endocal.files.decoder_words import damage_in, decoder_words
from endocal.files.picture_header import deflate_damage

LZW, JPEG, DEFLATE, OLD_DEFLATE, PACKBITS = 5, 7, 8, 32946, 32773
PRIVATE_TAG = 65000


@pytest.fixture(autouse=True, params=["SILENT", "WARNING"])
def log_level(request: pytest.FixtureRequest) -> Iterator[int]:
    """OpenCV's log level, as the command line sets it and as it is by itself."""
    logging = cv2.utils.logging
    before = logging.getLogLevel()
    level = getattr(logging, f"LOG_LEVEL_{request.param}")
    logging.setLogLevel(level)
    yield level
    logging.setLogLevel(before)


def scene(channels: int = 3) -> np.ndarray:
    """A soft picture with some grain, so that each compression has something to say of it."""
    grain = np.random.default_rng(8).normal(0, 3, (256, 320, channels))
    y, x = np.mgrid[:256, :320]
    waves = 128 + 90 * np.sin(x / 17) * np.cos(y / 23)
    return np.clip(waves[..., None] + grain, 0, 255).astype(np.uint8)


def tiff(compression: int, image: np.ndarray | None = None) -> bytes:
    options = [cv2.IMWRITE_TIFF_COMPRESSION, compression, cv2.IMWRITE_TIFF_ROWSPERSTRIP, 16]
    done, data = cv2.imencode(".tif", scene() if image is None else image, options)
    assert done
    return data.tobytes()


def damaged(data: bytes, share: float = 0.5) -> bytes:
    at = int(len(data) * share)
    return data[:at] + bytes(300) + data[at + 300 :]


def with_directory(data: bytes, extra: bytes = b"", following: int = 0) -> bytes:
    """The TIFF with its directory written anew at its end, one tag more in it, another directory after it."""
    (start,) = struct.unpack_from("<I", data, 4)
    (count,) = struct.unpack_from("<H", data, start)
    entries = data[start + 2 : start + 2 + 12 * count] + extra
    body = data + b"\0" * (len(data) % 2)
    directory = struct.pack("<H", len(entries) // 12) + entries + struct.pack("<I", following)
    return body[:4] + struct.pack("<I", len(body)) + body[8:] + directory


@pytest.mark.parametrize("share", [0.3, 0.5, 0.7])
@pytest.mark.parametrize("compression", [LZW, JPEG, DEFLATE, OLD_DEFLATE, PACKBITS])
def test_damage_in_the_middle_is_refused(compression: int, share: float, log_level: int) -> None:
    whole = tiff(compression)
    assert decode_image(whole, "board.tif").shape == (256, 320, 3)
    with pytest.raises(
        InputError, match=r"^board\.tif: is damaged in the middle \(.+\): take another copy of it$"
    ):
        decode_image(damaged(whole, share), "board.tif")
    assert cv2.utils.logging.getLogLevel() == log_level


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.integers(0, 10**9), st.integers(1, 255))
def test_any_one_wrong_byte_of_deflated_pixels_is_found(place: int, change: int) -> None:
    whole = tiff(DEFLATE)
    (directory,) = struct.unpack_from("<I", whole, 4)
    # OpenCV writes the strips first, and what describes them behind.
    at = 8 + place % (directory // 2)
    spoilt = bytearray(whole)
    spoilt[at] ^= change
    with pytest.raises(InputError, match="is damaged in the middle"):
        decode_image(bytes(spoilt))


def test_deflated_pixels_with_their_bits_the_other_way_are_no_damage() -> None:
    one_strip = tiff(DEFLATE, scene()[:16])
    (directory,) = struct.unpack_from("<I", one_strip, 4)
    bits = np.unpackbits(np.frombuffer(one_strip[8:directory], np.uint8), bitorder="little")
    turned = one_strip[:8] + np.packbits(bits).tobytes() + one_strip[directory:]
    fill_order = struct.pack("<HHIHH", 266, 3, 1, 2, 0)
    assert np.array_equal(decode_image(with_directory(turned, fill_order)), scene()[:16])


def test_a_few_bytes_that_inflate_to_much_are_left_alone() -> None:
    plain = tiff(DEFLATE, np.zeros((256, 320), np.uint8))
    bomb = zlib.compress(bytes(1 << 27))[:-4] + b"none"
    entries = {273: len(plain), 279: len(bomb), 278: 256}
    (start,) = struct.unpack_from("<I", plain, 4)
    (count,) = struct.unpack_from("<H", plain, start)
    data = bytearray(plain + bomb)
    for at in range(start + 2, start + 2 + 12 * count, 12):
        (tag,) = struct.unpack_from("<H", data, at)
        if tag in entries:
            struct.pack_into("<HHII", data, at, tag, 4, 1, entries[tag])
    assert deflate_damage(bytes(data)) is None


@pytest.mark.parametrize(
    "entry",
    [
        struct.pack("<HHII", PRIVATE_TAG, 4, 1, 7),
        struct.pack("<HHII", PRIVATE_TAG, 99, 1, 7),
        struct.pack("<HHII", PRIVATE_TAG, 4, 1000, 10**9),
    ],
    ids=["unknown", "of an unknown type", "off the end"],
)
def test_a_private_tag_is_no_damage(entry: bytes) -> None:
    plain = tiff(LZW)
    tagged = with_directory(plain, entry)
    with decoder_words() as words:
        cv2.imdecode(np.frombuffer(tagged, np.uint8), cv2.IMREAD_COLOR)
    # Something is said, and it is not of the pixels.
    assert words
    assert np.array_equal(decode_image(tagged), decode_image(plain))


def test_a_next_page_that_is_not_there_is_no_damage() -> None:
    plain = tiff(LZW)
    assert np.array_equal(decode_image(with_directory(plain, following=10**9)), decode_image(plain))


def test_pages_are_no_damage() -> None:
    pages = cv2.imencodemulti(".tif", [scene(), scene()[:100]])[1].tobytes()
    assert np.array_equal(decode_image(pages), scene())


@pytest.mark.parametrize(
    ("line", "damage"),
    [
        ("Corrupt JPEG data: premature end of data segment", "premature end of data segment"),
        ("Corrupt JPEG data: 7 extraneous bytes before marker 0xd9", None),
        ("TIFF_Warning JPEGLib: Corrupt JPEG data: 7 extraneous bytes before marker 0xd9", None),
        ("TIFF_Error Fax4Decode: Bad code word at line 186", "Bad code word at line 186"),
        ("TIFF_Error Using code not yet in table", "Using code not yet in table"),
        ("TIFF_Error TIFFFetchNormalTag: thus tag is not read from file", None),
        ("TIFF_Warning TIFFReadDirectory: Unknown field with tag 65000", None),
    ],
)
@pytest.mark.parametrize("before", ["", "[ WARN:0@0.4] global grfmt_tiff.cpp:123 "])
def test_words_of_damage(before: str, line: str, damage: str | None) -> None:
    assert damage_in(["something else", before + line]) == damage
