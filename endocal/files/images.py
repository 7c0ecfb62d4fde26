"""Still pictures in and out: 8 or 16 bit, grey or BGR, never half of one.

A picture is read as the sensor stored it. An EXIF orientation tag tells how to hold it for the eye, but
a lens sits before the sensor: the centre and the frame size of two pictures agree only in the sensor's
own frame, which is also what a video of the same camera holds. ``upright`` turns a result for the eye.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, OutputError
from .atomic import atomic_output
from .decoder_words import damage_in, decoder_words
from .names import NO_SUCH_FILE, PathLike, shown
from .picture_header import SIGNATURE_BYTES, as_stored, deflate_damage, known_kind, read_header

Picture = NDArray[np.uint8] | NDArray[np.uint16]

_MAX_PIXELS = 200_000_000
_MIN_SIDE = 2
# Uncompressed 16-bit RGBA at that limit, with room for metadata.
_MAX_BYTES = 9 * _MAX_PIXELS

_READ = cv2.IMREAD_ANYDEPTH | cv2.IMREAD_ANYCOLOR | cv2.IMREAD_IGNORE_ORIENTATION
# Visually lossless, and without the halved colour that is JPEG's default.
_JPEG = [
    cv2.IMWRITE_JPEG_QUALITY,
    95,
    cv2.IMWRITE_JPEG_SAMPLING_FACTOR,
    cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444,
]
# File name suffix -> encoder options; and those that keep 16 bits.
_ENCODERS: dict[str, list[int]] = {
    ".png": [],
    ".jpg": _JPEG,
    ".jpeg": _JPEG,
    ".tif": [],
    ".tiff": [],
    ".bmp": [],
}
_DEEP = (".png", ".tif", ".tiff")
# BMP files: their fourth channel is mostly left empty, which would make all of the picture transparent.
_OPAQUE = b"BM"

PICTURE_SUFFIXES = tuple(_ENCODERS)
# The kinds that hold transparency too.
ALPHA_SUFFIXES = _DEEP


def read_image(path: PathLike) -> Picture:
    """Read a PNG, JPEG, TIFF or BMP picture: uint8 or uint16, (h, w) grey or (h, w, 3) BGR.

    Transparency is dropped, palettes are expanded, EXIF orientation is not applied (see the module).
    Raises InputError for a file that is missing, unreadable, empty, no picture, truncated or damaged,
    smaller than 2 px a side, or over 200 megapixels; the last without decoding it.
    """
    return decode_image(read_picture_bytes(path), shown(path))


def read_picture_bytes(path: PathLike) -> bytes:
    """Return a picture file's bytes, to be decoded or hashed; InputError where it is no picture file."""
    name = shown(path)
    try:
        with open(path, "rb") as file:
            start = file.read(SIGNATURE_BYTES)
            if start and not known_kind(start):
                raise InputError(
                    f"{name}: is not a PNG, JPEG, TIFF or BMP picture: convert it to one, or take a still of"
                    " the recording"
                )
            data = start + file.read(_MAX_BYTES)
    except FileNotFoundError:
        pipe = "no such file: a picture is not read from a pipe, write it to a file"
        raise InputError(f"{name}: {pipe if name == '-' else NO_SUCH_FILE}") from None
    except IsADirectoryError:
        raise InputError(f"{name}: is a directory, not a picture: name a file in it") from None
    except (OSError, ValueError) as error:
        raise InputError(f"{name}: cannot be read: {getattr(error, 'strerror', error)}") from None
    if len(data) > _MAX_BYTES:
        raise InputError(
            f"{name}: the file is over {_MAX_BYTES >> 20} MiB, too large for a picture"
        )
    return data


def decode_image(data: bytes, name: str = "<picture>", keep_alpha: bool = False) -> Picture:
    """Decode the bytes of a picture file, as ``read_image`` does; ``name`` is what errors call it.

    With ``keep_alpha`` a picture that has transparency comes as (h, w, 4) BGRA.
    """
    if not data:
        raise InputError(f"{name}: is empty: take another copy of it")
    try:
        header = read_header(data)
    except InputError as error:
        raise InputError(f"{name}: {error}") from None
    size = f"{header.width}x{header.height}"
    if header.width * header.height > _MAX_PIXELS:
        raise InputError(
            f"{name}: {size} is over {_MAX_PIXELS // 1_000_000} megapixels: scale it down"
        )
    if min(header.width, header.height) < _MIN_SIDE:
        raise InputError(f"{name}: {size} px is too small to be a picture of anything")
    if header.damage:
        raise InputError(f"{name}: {header.damage}")
    flags = cv2.IMREAD_UNCHANGED if keep_alpha else _READ
    try:
        with decoder_words() as words:
            image: Any = cv2.imdecode(np.frombuffer(as_stored(data), np.uint8), flags)
    except (cv2.error, MemoryError):
        image = None
    damage = damage_in(words) or deflate_damage(data)
    if damage is not None:
        raise InputError(f"{name}: is damaged in the middle ({damage}): take another copy of it")
    if image is None:
        raise InputError(
            f"{name}: cannot be decoded: it is damaged, or of a kind that OpenCV does not read: take another"
            " copy of it, or convert it to PNG"
        )
    if image.dtype not in (np.uint8, np.uint16):
        raise InputError(
            f"{name}: has {image.dtype} pixels: convert it to whole numbers of 8 or 16 bits a channel"
        )
    if keep_alpha and image.ndim == 3 and image.shape[2] == 4 and not data.startswith(_OPAQUE):
        return np.ascontiguousarray(image)
    return without_alpha(image)


def upright(image: Picture, data: bytes) -> Picture:
    """Turn a picture as the EXIF orientation in its file's bytes says; return it as it is without one."""
    orientation = read_header(data).orientation
    turned: Any = image.swapaxes(0, 1) if orientation >= 5 else image
    if orientation in (2, 3, 6, 7):
        turned = turned[:, ::-1]
    if orientation in (3, 4, 7, 8):
        turned = turned[::-1]
    return np.ascontiguousarray(turned)


def encode_image(image: Picture, suffix: str) -> bytes:
    """Return the bytes of a picture file of the kind that ``suffix`` names, such as ``.png``.

    Raises OutputError for a suffix that no encoder is known for, and for 16 bits in a kind that has 8.
    """
    suffix = suffix.lower()
    if suffix not in _ENCODERS:
        known = ", ".join(_ENCODERS)
        raise OutputError(
            f"pictures are written as {known}, not as {suffix or 'a name without suffix'!r}"
        )
    if image.dtype == np.uint16 and suffix not in _DEEP:
        raise OutputError(f"a 16-bit picture does not fit into {suffix}: write .png or .tif")
    done, data = cv2.imencode(suffix, image, _ENCODERS[suffix])
    if not done:
        raise OutputError(f"the picture cannot be encoded as {suffix}")
    return data.tobytes()


def write_image(path: PathLike, image: Picture, overwrite: bool = False) -> None:
    """Write a picture, of the kind that the name's suffix tells; raises OutputError, see ``encode_image``."""
    try:
        data = encode_image(image, Path(os.fspath(path)).suffix)
    except OutputError as error:
        raise OutputError(f"{shown(path)}: {error}") from None
    with atomic_output(path, overwrite) as temporary:
        temporary.write_bytes(data)


def without_alpha(image: Any) -> Picture:
    """Return a picture without its transparency, if it has any."""
    if image.ndim == 3 and image.shape[2] == 4:
        image = image[:, :, :3]
    elif image.ndim == 3 and image.shape[2] in (1, 2):
        image = image[:, :, 0]
    return np.ascontiguousarray(image)
