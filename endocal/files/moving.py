"""Whether what begins like a still picture goes on as a moving one: motion JPEG, animated PNG.

A JPEG may be followed by others that belong to it: a thumbnail, a gain map, the other eye's view. These
differ from it in size, or it says so in a marker of its own (CIPA DC-007).
"""

from __future__ import annotations

import struct
from collections.abc import Callable

from ..errors import InputError
from .picture_header import JPEG, JPEG_END, JPEG_FRAMES, PNG, jpeg_markers, jpeg_size

_FIRST_LOOK = 1 << 16
_APP2, _MULTI_PICTURE = 0xE2, b"MPF\0"


def is_moving(peek: Callable[[int], bytes]) -> bool:
    """Tell whether a file holds further pictures that follow the first one in time.

    ``peek`` returns the first so many bytes of the file, or all there are. No more is asked for than is
    needed to tell, which for a JPEG is the whole of the first picture.
    """
    size = _FIRST_LOOK
    while True:
        data = peek(size)
        try:
            if data.startswith(PNG):
                return _is_animated(data)
            return data.startswith(JPEG) and _goes_on(data)
        except (IndexError, struct.error):
            if len(data) < size:
                return False
        except InputError:
            return False
        size *= 4


def _is_animated(data: bytes) -> bool:
    at = len(PNG)
    while True:
        length, kind = struct.unpack_from(">I4s", data, at)
        if kind == b"acTL":
            frames: int = struct.unpack_from(">I", data, at + 8)[0]
            return frames > 1
        if kind in (b"IDAT", b"IEND"):
            return False
        at += 12 + length


def _goes_on(data: bytes) -> bool:
    """Tell whether a JPEG is followed by another one of its size; IndexError where more data would tell."""
    size = None
    marker, at = 0, 0
    for marker, at in jpeg_markers(data):
        if marker in JPEG_FRAMES:
            size = jpeg_size(data, at)
        if marker == _APP2 and data.startswith(_MULTI_PICTURE, at + 4):
            return False
    following = at + 2
    if marker != JPEG_END or len(data) < following + len(JPEG):
        raise IndexError
    if not data.startswith(JPEG, following):
        return False
    frames = (at for marker, at in jpeg_markers(data, following + 2) if marker in JPEG_FRAMES)
    first = next(frames, None)
    return first is not None and jpeg_size(data, first) == size
