"""Live inputs: addresses and cameras that are read as they come."""

from __future__ import annotations

import re

import av
import av.container

from ..errors import InputError
from .access import MAX_SIDE, reason

SCHEMES = ("rtsp", "rtsps", "rtp", "udp", "tcp", "srt", "rtmp", "rtmps", "http", "https")
# What the schemes need underneath.
_PROTOCOLS = (*SCHEMES, "tls", "srtp", "crypto", "httpproxy")
_CAMERA = "/dev/video"
# Seconds that an input may take to begin, and after it has begun, to send anything.
_OPEN_S, SILENCE_S = 15.0, 5.0
_OPTIONS = {
    "rtsp_transport": "tcp",
    # Enough to know the streams; a file's default would hold back five seconds.
    "probesize": "1000000",
    "analyzeduration": "1000000",
    "max_pixels": str(MAX_SIDE**2),
}


def is_address(source: str) -> bool:
    """Tell an address or a camera from a path."""
    return source.startswith(_CAMERA) or re.match(r"[a-z]+://", source) is not None


def redacted(address: str) -> str:
    """Return an address without the user and password in it."""
    return re.sub(r"(?<=://)[^/@]*@", "", address)


def open_live(address: str, name: str) -> av.container.InputContainer:
    """Open an address of one of SCHEMES, or a camera as /dev/video0.

    ``name`` is what messages call it. Raises InputError where it cannot be opened or does not begin.
    """
    is_camera = address.startswith(_CAMERA)
    scheme = address.partition("://")[0]
    if not is_camera and scheme not in SCHEMES:
        raise InputError(
            f"{name}: is no live input; those are /dev/video0 and the like, and addresses with"
            f" {', '.join(SCHEMES)}"
        )
    try:
        return av.open(
            address,
            mode="r",
            format="v4l2" if is_camera else None,
            options=_OPTIONS
            if is_camera
            else {**_OPTIONS, "protocol_whitelist": ",".join(_PROTOCOLS)},
            metadata_errors="replace",
            timeout=(_OPEN_S, SILENCE_S),
        )
    except av.error.ExitError as error:
        raise InputError(f"{name}: nothing came within {_OPEN_S:g} s") from error
    except (av.error.FFmpegError, ValueError) as error:
        raise InputError(f"{name}: cannot be opened ({reason(error)})") from error
