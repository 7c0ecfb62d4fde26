"""Whether a file holds all the bytes that its container speaks of, read from the container's own structure.

Matroska is built of elements and MP4 of boxes, each of which begins with its size: what reaches beyond the
end of the file has been cut off, however little it is. EBML: RFC 8794; Matroska: RFC 9559; boxes: ISO/IEC
14496-12.
"""

from __future__ import annotations

import os
from typing import BinaryIO

_EBML, _SEGMENT = 0x1A45DFA3, 0x18538067
# Kinds of boxes that a file may begin with.
_FIRST_BOXES = (b"ftyp", b"moov", b"mdat", b"wide", b"free", b"skip", b"styp")


def is_cut_off(path: str) -> bool | None:
    """Tell whether a Matroska, WebM, MP4 or MOV file has lost its end; None where it does not tell."""
    try:
        with open(path, "rb") as file:
            end = os.fstat(file.fileno()).st_size
            head = file.read(8)
            file.seek(0)
            if head[4:] in _FIRST_BOXES:
                return _boxes_end(file, end)
            return _elements_end(file, end) if head[:4] == _EBML.to_bytes(4, "big") else None
    except (OSError, ValueError):
        return None


def _boxes_end(file: BinaryIO, end: int) -> bool:
    at = 0
    while at < end:
        file.seek(at)
        head = file.read(16)
        size = int.from_bytes(head[:4], "big")
        if size == 1:
            size = int.from_bytes(head[8:], "big")
        if size == 0 or (at > 0 and not head[4:8].isalnum()):
            return False  # to the end of the file; or padding that is no box
        if size < 8:
            return len(head) < 8
        at += size
    return at > end


def _elements_end(file: BinaryIO, end: int) -> bool | None:
    while file.tell() < end:
        head = _element(file)
        if head is None:
            return None
        kind, size = head
        if size is None:
            if kind != _SEGMENT:
                return None  # a cluster that was written as it came, and does not know its own end
            continue  # a recording that was never finished: what is in it may still tell
        if file.tell() + size > end:
            return True
        if kind == _SEGMENT:
            return False
        file.seek(size, os.SEEK_CUR)
    return False


def _element(file: BinaryIO) -> tuple[int, int | None] | None:
    """Read an element's kind and size (None: not known); None where there is no element."""
    kind = _number(file, keep_mark=True)
    size = _number(file, keep_mark=False)
    if kind is None or size is None:
        return None
    value, length = size
    return kind[0], None if value == (1 << (7 * length)) - 1 else value


def _number(file: BinaryIO, keep_mark: bool) -> tuple[int, int] | None:
    """Read a number of EBML, whose leading zero bits tell its length; return it and that."""
    first = file.read(1)
    if not first or first == b"\0":
        return None
    length = 9 - first[0].bit_length()
    rest = file.read(length - 1)
    if len(rest) < length - 1:
        return None
    value = int.from_bytes(first + rest, "big")
    return (value if keep_mark else value & ((1 << (7 * length)) - 1)), length
