"""What a picture file says of itself, read without decoding: its size, and whether all of it is there.

Decoders differ in what they do with a file that stops in the middle: some fail, some fill the rest with
grey and say nothing. PNG (W3C), JPEG (ITU-T T.81), TIFF 6.0 with BigTIFF, and BMP.
"""

from __future__ import annotations

import re
import struct
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction

from ..errors import InputError

PNG = b"\x89PNG\r\n\x1a\n"
JPEG = b"\xff\xd8\xff"
_BMP = b"BM"
_TIFF_ORDER = {b"II*\0": "<", b"MM\0*": ">", b"II+\0": "<", b"MM\0+": ">"}

# The longest of the signatures.
SIGNATURE_BYTES = 8

# JPEG: markers that start a frame; markers without a length; a marker inside entropy-coded data that ends
# it (any but a stuffed zero, a restart, and fill bytes).
JPEG_FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
_JPEG_BARE = frozenset((0x01, *range(0xD0, 0xD8)))
_JPEG_SCAN_END = re.compile(rb"\xff[^\x00\xd0-\xd7\xff]")
JPEG_END = 0xD9
_JPEG_SCAN, _JPEG_APP1 = 0xDA, 0xE1
_EXIF = b"Exif\0\0"

# TIFF: tags, and the byte size and struct letter of the field types that hold sizes and offsets.
_WIDTH, _HEIGHT, _STRIPS, _STRIP_BYTES, _TILES, _TILE_BYTES = 256, 257, 273, 279, 324, 325
_COMPRESSION, _FILL_ORDER, _ORIENTATION = 259, 266, 274
_PLACES = (_STRIPS, _STRIP_BYTES, _TILES, _TILE_BYTES)
_TAGS = (_WIDTH, _HEIGHT, _COMPRESSION, _FILL_ORDER, _ORIENTATION, *_PLACES)
_DEFLATE = (8, 32946)
# None, CCITT, LZW, JPEG, Deflate, PackBits. Of any other OpenCV makes a black picture without a word.
_TIFF_COMPRESSIONS = frozenset((1, 2, 3, 4, 5, 7, 32773, *_DEFLATE))
_TIFF_TYPES = {3: "H", 4: "I", 16: "Q"}
_TIFF_RATIO = 5

# Deflated strips are inflated up to so many bytes a pixel, and some more for tiles that overlap the edge: 16
# bits of four channels take half of it, and a few bytes that inflate to gigabytes are left alone.
_INFLATED_PER_PIXEL, _INFLATED_MORE = 16, 64 << 20

_REMEDY = "take another copy of it"
_TRUNCATED = f"is truncated: the end of the picture is missing: {_REMEDY}"


@dataclass(frozen=True)
class PictureHeader:
    """The size in px of the stored picture, and what is said of the file.

    ``damage`` is in words what is missing of it, and what to do; None where nothing is. ``orientation`` is
    EXIF's: how to turn the stored picture for the eye, 1 (not at all) to 8. A TIFF may hold several
    ``pages``; what is said here is said of the first.
    """

    width: int
    height: int
    damage: str | None = None
    orientation: int = 1
    pages: int = 1


def read_header(data: bytes) -> PictureHeader:
    """Return what a picture file's bytes say; InputError where they are no picture of a known kind."""
    reader = _reader(data)
    if reader is None:
        raise InputError("is not a PNG, JPEG, TIFF or BMP picture")
    try:
        header = reader(data)
    except (struct.error, IndexError, OverflowError, MemoryError):
        raise InputError(_TRUNCATED) from None
    if header.width < 1 or header.height < 1:
        raise InputError(f"is damaged: its header gives no size: {_REMEDY}")
    return header


def known_kind(start: bytes) -> bool:
    """Say whether a file that starts with these 8 bytes is a picture of a known kind."""
    return _reader(start) is not None


def as_stored(data: bytes) -> bytes:
    """A picture file's bytes, a TIFF's without its orientation: OpenCV turns a TIFF that has one, unasked."""
    if data[:4] not in _TIFF_ORDER:
        return data
    order, big = _tiff_kind(data)
    stored = bytearray(data)
    for tag, kind, _, at in _tiff_entries(data):
        if tag == _ORIENTATION and kind in _TIFF_TYPES:
            struct.pack_into(order + _TIFF_TYPES[kind], stored, at + (12 if big else 8), 1)
    return bytes(stored)


def deflate_damage(data: bytes) -> str | None:
    """Return what is wrong with the deflated strips or tiles of a TIFF's first page; None for nothing.

    Each ends in a checksum, which libtiff, content with the last pixel, mostly does not come to.
    """
    if data[:4] not in _TIFF_ORDER:
        return None
    tags = _tiff_tags(data)
    # Fill order 2, which is rare, turns the bits of each byte around.
    turned = (tags.get(_FILL_ORDER) or (1,))[0] == 2
    if turned or (tags.get(_COMPRESSION) or (1,))[0] not in _DEFLATE:
        return None
    left = _INFLATED_PER_PIXEL * tags[_WIDTH][0] * tags[_HEIGHT][0] + _INFLATED_MORE
    for offsets, sizes in ((_STRIPS, _STRIP_BYTES), (_TILES, _TILE_BYTES)):
        for start, length in zip(tags.get(offsets, ()), tags.get(sizes, ()), strict=False):
            stream = zlib.decompressobj()
            rest = data[start : start + length]
            try:
                while rest and not stream.eof and left > 0:
                    left -= len(stream.decompress(rest, min(left, _INFLATED_MORE)))
                    rest = stream.unconsumed_tail
            except zlib.error as error:
                return str(error)
    return None


def _reader(data: bytes) -> Callable[[bytes], PictureHeader] | None:
    if data.startswith(PNG):
        return _read_png
    if data.startswith(JPEG):
        return _read_jpeg
    if data[:4] in _TIFF_ORDER:
        return _read_tiff
    if data.startswith(_BMP):
        return _read_bmp
    return None


def _read_png(data: bytes) -> PictureHeader:
    length, kind, width, height = struct.unpack_from(">I4sII", data, 8)
    if kind != b"IHDR" or length != 13:
        raise InputError(f"is damaged: a PNG without a header: {_REMEDY}")
    orientation = 1
    for kind, at, end in png_chunks(data):
        (checksum,) = struct.unpack_from(">I", data, end)
        if zlib.crc32(memoryview(data)[at - 4 : end]) != checksum:
            damage = f"is damaged: a checksum in it is wrong: {_REMEDY}"
            return PictureHeader(width, height, damage)
        if kind == b"eXIf":
            orientation = _exif_orientation(data[at:end])
        if kind == b"IEND":
            return PictureHeader(width, height, None, orientation)
    return PictureHeader(width, height, _TRUNCATED)


def png_chunks(data: bytes) -> Iterator[tuple[bytes, int, int]]:
    """Yield the chunks of a PNG that are all there: what kind, and from where to where they say it."""
    at = len(PNG)
    while at + 12 <= len(data):
        length, kind = struct.unpack_from(">I4s", data, at)
        end = at + 8 + length
        if end + 4 > len(data):
            return
        yield kind, at + 8, end
        at = end + 4


def _read_jpeg(data: bytes) -> PictureHeader:
    size: tuple[int, int] | None = None
    orientation, last = 1, 0
    for last, at in jpeg_markers(data):
        if last in JPEG_FRAMES and size is None:
            size = jpeg_size(data, at)
        if last == _JPEG_APP1 and data.startswith(_EXIF, at + 4):
            (length,) = struct.unpack_from(">H", data, at + 2)
            orientation = _exif_orientation(data[at + 4 + len(_EXIF) : at + 2 + length])
    if size is None:
        raise InputError(f"is damaged: a JPEG without a picture: {_REMEDY}")
    return PictureHeader(*size, None if last == JPEG_END else _TRUNCATED, orientation)


def jpeg_markers(data: bytes, at: int = 2) -> Iterator[tuple[int, int]]:
    """Yield each marker of a JPEG, and where it stands, from ``at`` to the end marker, if that is there.

    Raises InputError for what is no marker where one must be; IndexError or struct.error where the data end.
    """
    while True:
        while data[at] == 0xFF and data[at + 1] == 0xFF:
            at += 1
        if data[at] != 0xFF:
            raise InputError(f"is damaged: no JPEG marker where one must be: {_REMEDY}")
        marker = data[at + 1]
        yield marker, at
        if marker == JPEG_END:
            return
        if marker in _JPEG_BARE:
            at += 2
            continue
        (length,) = struct.unpack_from(">H", data, at + 2)
        at += 2 + length
        if marker == _JPEG_SCAN:
            found = _JPEG_SCAN_END.search(data, at)
            if found is None:
                return
            at = found.start()


def jpeg_size(data: bytes, at: int) -> tuple[int, int]:
    """Return (width, height) from the marker at ``at``, one of JPEG_FRAMES."""
    height, width = struct.unpack_from(">HH", data, at + 5)
    return width, height


def _read_tiff(data: bytes) -> PictureHeader:
    tags = _tiff_tags(data)
    if not tags.get(_WIDTH) or not tags.get(_HEIGHT):
        raise InputError(f"is damaged: a TIFF without a size: {_REMEDY}")
    compression = (tags.get(_COMPRESSION) or (1,))[0]
    if compression not in _TIFF_COMPRESSIONS:
        raise InputError(
            f"is a TIFF with a compression (number {compression}) that is not read: save it as PNG"
        )
    damage = None
    for offsets, sizes in ((_STRIPS, _STRIP_BYTES), (_TILES, _TILE_BYTES)):
        ends = (o + n for o, n in zip(tags.get(offsets, ()), tags.get(sizes, ()), strict=False))
        if max(ends, default=0) > len(data):
            damage = _TRUNCATED
    pages = sum(1 for _ in _tiff_directories(data))
    return PictureHeader(tags[_WIDTH][0], tags[_HEIGHT][0], damage, _orientation(tags), pages)


def _tiff_directories(data: bytes) -> Iterator[tuple[int, int]]:
    """Yield where each directory of a TIFF has its first tag, and how many; one that is cut off ends them."""
    order, big = _tiff_kind(data)
    place, number = order + ("Q" if big else "I"), order + ("Q" if big else "H")
    seen: set[int] = set()
    (start,) = struct.unpack_from(place, data, 8 if big else 4)
    while start and start not in seen and start + struct.calcsize(number) <= len(data):
        seen.add(start)
        (count,) = struct.unpack_from(number, data, start)
        first = start + struct.calcsize(number)
        yield first, count
        end = first + count * (20 if big else 12)
        there = end + struct.calcsize(place) <= len(data)
        (start,) = struct.unpack_from(place, data, end) if there else (0,)


def is_tiff(data: bytes) -> bool:
    """Say whether a file's bytes are a TIFF's."""
    return data[:4] in _TIFF_ORDER


def tiff_ratio(data: bytes, wanted: int) -> Fraction:
    """Return the ratio that a tag of a TIFF's first directory gives; 0 where it gives none."""
    order, big = _tiff_kind(data)
    for tag, kind, length, at in _tiff_entries(data):
        if tag == wanted and kind == _TIFF_RATIO and length == 1:
            if not big:
                (at,) = struct.unpack_from(order + "I", data, at + 8)
            over, under = struct.unpack_from(order + "II", data, at + (12 if big else 0))
            return Fraction(over, under) if under else Fraction(0)
    return Fraction(0)


def _tiff_kind(data: bytes) -> tuple[str, bool]:
    """The byte order of a TIFF, as struct has it, and whether it is a BigTIFF."""
    return _TIFF_ORDER[data[:4]], data[2:4] in (b"+\0", b"\0+")


def _tiff_tags(data: bytes) -> dict[int, tuple[int, ...]]:
    """Return the tags we know of a TIFF's first directory; EXIF data is a TIFF of its own."""
    order, big = _tiff_kind(data)
    tags: dict[int, tuple[int, ...]] = {}
    for tag, kind, length, at in _tiff_entries(data):
        letter = _TIFF_TYPES.get(kind)
        if tag not in _TAGS or not letter:
            continue
        if length * struct.calcsize(letter) > len(data):
            raise InputError(_TRUNCATED)
        values = at + (12 if big else 8)
        if length * struct.calcsize(letter) > (8 if big else 4):
            (values,) = struct.unpack_from(order + ("Q" if big else "I"), data, values)
        tags[tag] = struct.unpack_from(f"{order}{length}{letter}", data, values)
    return tags


def _tiff_entries(data: bytes) -> Iterator[tuple[int, int, int, int]]:
    """Yield the tags of a TIFF's first directory: number, type, how many values, and where the entry is."""
    order, big = _tiff_kind(data)
    first, count = next(_tiff_directories(data), (len(data), 1))
    for i in range(min(count, 4096)):
        at = first + i * (20 if big else 12)
        yield (*struct.unpack_from(order + ("HHQ" if big else "HHI"), data, at), at)


def _exif_orientation(exif: bytes) -> int:
    """Return the orientation that EXIF data gives; 1 where it gives none or is broken."""
    try:
        return _orientation(_tiff_tags(exif))
    except (KeyError, struct.error, InputError):
        return 1


def _orientation(tags: dict[int, tuple[int, ...]]) -> int:
    value = (tags.get(_ORIENTATION) or (1,))[0]
    return value if 1 <= value <= 8 else 1


def _read_bmp(data: bytes) -> PictureHeader:
    start, header_size = (
        struct.unpack_from("<I", data, 10)[0],
        struct.unpack_from("<I", data, 14)[0],
    )
    if header_size == 12:
        width, height, _, bits = struct.unpack_from("<HHHH", data, 18)
        compression = 0
    else:
        width, height, _, bits, compression = struct.unpack_from("<iiHHI", data, 18)
    height = abs(height)
    # 0 and 3 are the uncompressed kinds; a run-length one does not tell its size.
    row = (width * bits + 31) // 32 * 4
    truncated = compression in (0, 3) and start + row * height > len(data)
    return PictureHeader(width, height, _TRUNCATED if truncated else None)
