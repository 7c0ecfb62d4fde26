"""Files in and out: calibrations and zoom tables as TOML, pictures, and outputs that are never half there."""

from .atomic import atomic_output, check_output
from .images import decode_image, encode_image, read_image, read_picture_bytes, upright, write_image
from .toml import dumps, load, loads, save

__all__ = [
    "atomic_output",
    "check_output",
    "decode_image",
    "dumps",
    "encode_image",
    "load",
    "loads",
    "read_image",
    "read_picture_bytes",
    "save",
    "upright",
    "write_image",
]
