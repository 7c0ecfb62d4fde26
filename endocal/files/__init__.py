"""Files in and out: calibrations and zoom tables as TOML, pictures, and outputs that are never half there."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .atomic import atomic_output, check_output
from .lines import read_lines
from .toml import dumps, load, loads, save

if TYPE_CHECKING:
    from .images import (
        decode_image,
        encode_image,
        read_image,
        read_picture_bytes,
        upright,
        write_image,
    )

__all__ = [
    "atomic_output",
    "check_output",
    "decode_image",
    "dumps",
    "encode_image",
    "load",
    "loads",
    "read_image",
    "read_lines",
    "read_picture_bytes",
    "save",
    "upright",
    "write_image",
]


def __getattr__(name: str) -> Any:
    """Import what deals with pictures, and OpenCV with it, when it is first asked for."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from . import images

    return getattr(images, name)
