"""Pictures of every kind come in as they are; what is no whole picture is refused by name."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from endocal.errors import InputError, OutputError
from endocal.files import decode_image, encode_image, read_image, upright, write_image
from endocal.files.picture_header import read_header

SUFFIXES = (".png", ".jpg", ".tif", ".bmp")
RNG = np.random.default_rng(5)
COLOUR = RNG.integers(0, 256, (37, 52, 3), np.uint8)
GREY = np.ascontiguousarray(COLOUR[..., 1])


def picture(suffix: str, image: np.ndarray = COLOUR) -> bytes:
    return cv2.imencode(suffix, image)[1].tobytes()


@pytest.mark.parametrize("image", [COLOUR, GREY], ids=["colour", "grey"])
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_round_trip(tmp_path: Path, suffix: str, image: np.ndarray) -> None:
    path = tmp_path / f"内視鏡 50%\nline{suffix}"
    write_image(path, image)
    read = read_image(path)
    assert read.dtype == np.uint8
    assert read.shape == image.shape
    if suffix == ".jpg":
        # Noise is the hardest there is to keep; at quality 95 the steps are a few levels wide.
        assert np.abs(read.astype(float) - image).mean() < 8
    else:
        assert np.array_equal(read, image)


@pytest.mark.parametrize("suffix", [".png", ".tif"])
@pytest.mark.parametrize("channels", [1, 3])
def test_sixteen_bits_stay(suffix: str, channels: int) -> None:
    shape = (20, 30) if channels == 1 else (20, 30, 3)
    deep = RNG.integers(0, 65536, shape).astype(np.uint16)
    read = decode_image(encode_image(deep, suffix))
    assert read.dtype == np.uint16
    assert np.array_equal(read, deep)


@pytest.mark.parametrize("suffix", [".jpg", ".bmp"])
def test_sixteen_bits_are_not_cut_to_eight(tmp_path: Path, suffix: str) -> None:
    with pytest.raises(OutputError, match="16-bit picture does not fit"):
        write_image(tmp_path / f"out{suffix}", GREY.astype(np.uint16))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("suffix", [".png", ".tif"])
def test_transparency_is_dropped(suffix: str) -> None:
    alpha = RNG.integers(0, 256, (*GREY.shape, 1), np.uint8)
    read = decode_image(picture(suffix, np.concatenate([COLOUR, alpha], axis=2)))
    assert np.array_equal(read, COLOUR)


def test_a_palette_is_expanded() -> None:
    palette = bytes([10, 20, 30, 200, 100, 50])
    rows = b"".join(b"\0" + bytes([x % 2 for x in range(4)]) for _ in range(3))
    header = struct.pack(">IIBBBBB", 4, 3, 8, 3, 0, 0, 0)
    data = png(header, [(b"PLTE", palette), (b"IDAT", zlib.compress(rows))])
    read = decode_image(data)
    assert read.shape == (3, 4, 3)
    assert read[0, :2].tolist() == [[30, 20, 10], [50, 100, 200]]


def png(header: bytes, chunks: list[tuple[bytes, bytes]]) -> bytes:
    out = b"\x89PNG\r\n\x1a\n"
    for kind, data in [(b"IHDR", header), *chunks, (b"IEND", b"")]:
        out += (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )
    return out


def exif(orientation: int, order: str) -> bytes:
    """EXIF data with one tag: the orientation."""
    start = b"II*\0" if order == "<" else b"MM\0*"
    return start + struct.pack(f"{order}IHHHIHHI", 8, 1, 0x0112, 3, 1, orientation, 0, 0)


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("orientation", range(1, 9))
def test_the_sensor_frame_is_kept_whatever_exif_says(orientation: int, order: str) -> None:
    # A corner patch and a ramp: no two of the eight orientations look alike.
    image = np.repeat(np.linspace(0, 200, 64).astype(np.uint8)[None], 32, axis=0)
    image[:8, :16] = 255
    plain = picture(".jpg", image)
    segment = b"Exif\0\0" + exif(orientation, order)
    tagged = plain[:2] + b"\xff\xe1" + struct.pack(">H", len(segment) + 2) + segment + plain[2:]
    stored = decode_image(tagged)
    assert np.array_equal(stored, decode_image(plain))
    # OpenCV turns by the tag on its own where it is not told otherwise: an independent truth.
    turned = cv2.imdecode(np.frombuffer(tagged, np.uint8), cv2.IMREAD_GRAYSCALE)
    assert np.array_equal(upright(stored, tagged), turned)


def test_orientation_in_png_and_tiff() -> None:
    rows = zlib.compress(b"".join(b"\0" + bytes([y, y, y]) for y in range(2)))
    header = struct.pack(">IIBBBBB", 3, 2, 8, 0, 0, 0, 0)
    data = png(header, [(b"eXIf", exif(6, ">")), (b"IDAT", rows)])
    assert upright(decode_image(data), data).tolist() == [[1, 0]] * 3
    plain = picture(".tif", GREY)
    assert np.array_equal(upright(GREY, plain), GREY)


def turned_tiff(image: np.ndarray, orientation: int) -> bytes:
    """A TIFF whose directory, written anew at its end, has an orientation tag."""
    plain = picture(".tif", image)
    order = "<" if plain.startswith(b"II") else ">"
    (start,) = struct.unpack_from(order + "I", plain, 4)
    (count,) = struct.unpack_from(order + "H", plain, start)
    entries = [plain[start + 2 + 12 * i :][:12] for i in range(count)]
    entries = [e for e in entries if struct.unpack_from(order + "H", e)[0] != 274]
    entries.append(struct.pack(order + "HHIHH", 274, 3, 1, orientation, 0))
    entries.sort(key=lambda e: struct.unpack_from(order + "H", e)[0])
    body = plain + b"\0" * (len(plain) % 2)
    directory = struct.pack(order + "H", len(entries)) + b"".join(entries) + bytes(4)
    return body[:4] + struct.pack(order + "I", len(body)) + body[8:] + directory


@pytest.mark.parametrize("deep", [np.uint8, np.uint16])
@pytest.mark.parametrize("orientation", range(1, 9))
def test_a_tiff_is_kept_in_the_sensor_frame_too(orientation: int, deep: type) -> None:
    image = np.repeat(np.linspace(0, 200, 64).astype(deep)[None], 32, axis=0)
    image[:8, :16] = 255
    tagged = turned_tiff(image, orientation)
    stored = decode_image(tagged)
    assert np.array_equal(stored, image)
    shape = image.shape if orientation < 5 else image.shape[::-1]
    assert upright(stored, tagged).shape == shape
    assert read_header(tagged).orientation == orientation


@pytest.mark.parametrize("count", [1, 3])
def test_the_pages_of_a_tiff_are_counted(count: int) -> None:
    pages = [np.full((12, 16), 60 * i, np.uint8) for i in range(count)]
    data = cv2.imencodemulti(".tif", pages)[1].tobytes()
    assert read_header(data).pages == count
    assert decode_image(data).tolist() == pages[0].tolist()
    assert read_header(picture(".png")).pages == 1


@pytest.mark.parametrize("order", ["<", ">"])
def test_pages_that_follow_themselves_end(order: str) -> None:
    mark = b"II*\0" if order == "<" else b"MM\0*"
    tags = b"".join(struct.pack(order + "HHII", t, 4, 1, 8) for t in (256, 257))
    data = mark + struct.pack(order + "IH", 8, 2) + tags + struct.pack(order + "I", 8)
    assert read_header(data).pages == 1


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("share", [0.02, 0.3, 0.6, 0.99])
def test_a_truncated_picture_is_refused(tmp_path: Path, suffix: str, share: float) -> None:
    data = picture(suffix)
    path = tmp_path / f"cut{suffix}"
    path.write_bytes(data[: max(9, int(len(data) * share))])
    with pytest.raises(
        InputError, match=r"cut.*: is (truncated|damaged)\b.*: take another copy of it$"
    ):
        read_image(path)


@given(st.sampled_from(SUFFIXES), st.data())
def test_any_truncation_is_an_error_of_ours(suffix: str, data: st.DataObject) -> None:
    whole = picture(suffix)
    end = data.draw(st.integers(0, len(whole) - 2))
    with pytest.raises(InputError):
        decode_image(whole[:end])


@given(st.sampled_from(SUFFIXES), st.data())
def test_any_damage_is_a_picture_or_an_error_of_ours(suffix: str, data: st.DataObject) -> None:
    whole = bytearray(picture(suffix, GREY[:12, :12]))
    for _ in range(data.draw(st.integers(1, 4))):
        whole[data.draw(st.integers(0, len(whole) - 1))] = data.draw(st.integers(0, 255))
    try:
        image = decode_image(bytes(whole))
    except InputError:
        return
    assert image.dtype in (np.uint8, np.uint16)
    assert image.ndim == 2 or image.shape[2] == 3


def test_a_damaged_png_is_named() -> None:
    data = bytearray(picture(".png"))
    data[len(data) // 2] ^= 0xFF
    with pytest.raises(InputError, match=r"a checksum in it is wrong: take another copy of it$"):
        decode_image(bytes(data))


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "is empty"),
        (b"hello", "is not a PNG, JPEG, TIFF or BMP picture"),
        (b"\0" * 4096, "is not a PNG, JPEG, TIFF or BMP picture"),
        (b"\x89PNG\r\n\x1a\n", "is truncated: .*: take another copy of it$"),
        (b"GIF89a" + b"\0" * 99, "is not a PNG"),
    ],
)
def test_what_is_no_picture(tmp_path: Path, data: bytes, message: str) -> None:
    path = tmp_path / "x.png"
    path.write_bytes(data)
    with pytest.raises(InputError, match=message):
        read_image(path)


def test_a_picture_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"-: no such file: a picture is not read from a pipe"):
        read_image("-")
    with pytest.raises(InputError, match=r"none\.png: no such file: check its name$"):
        read_image(tmp_path / "none.png")
    with pytest.raises(InputError, match=r"is a directory, not a picture: name a file in it$"):
        read_image(tmp_path)


def test_one_pixel_is_no_picture() -> None:
    with pytest.raises(InputError, match="1x1 px is too small"):
        decode_image(picture(".png", GREY[:1, :1]))


@pytest.mark.parametrize(
    "data",
    [
        png(struct.pack(">IIBBBBB", 20000, 10001, 8, 0, 0, 0, 0), [(b"IDAT", b"")]),
        b"\xff\xd8\xff\xc0" + struct.pack(">HBHHB", 11, 8, 60000, 60000, 1) + b"\1\x11\0\xff\xd9",
        b"II*\0\x08\0\0\0\x02\0" + struct.pack("<HHIIHHII", 256, 4, 1, 30000, 257, 4, 1, 9000),
        b"BM" + struct.pack("<IHHI", 54, 0, 0, 54) + struct.pack("<IiiHHI", 40, 99999, -99999, 1, 24, 0),
    ],
    ids=SUFFIXES,
)  # fmt: skip
def test_a_giant_is_refused_by_its_header(data: bytes) -> None:
    # None of these holds any pixels: the header alone must be enough.
    with pytest.raises(InputError, match="is over 200 megapixels"):
        decode_image(data)


def test_a_compression_that_nobody_knows_is_refused() -> None:
    data = bytearray(picture(".tif", GREY))
    entry = data.index(struct.pack("<HHI", 259, 3, 1))
    data[entry + 8 : entry + 10] = struct.pack("<H", 9999)
    with pytest.raises(
        InputError, match=r"compression \(number 9999\) that is not read: save it as PNG$"
    ):
        decode_image(bytes(data))


def test_float_pixels_are_refused() -> None:
    with pytest.raises(InputError, match="has float32 pixels: convert it to whole numbers"):
        decode_image(picture(".tif", GREY.astype(np.float32)))


def test_an_unknown_suffix_is_refused(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"out\.xyz: pictures are written as \.png"):
        write_image(tmp_path / "out.xyz", GREY)
    with pytest.raises(OutputError, match="a name without suffix"):
        write_image(tmp_path / "out", GREY)
