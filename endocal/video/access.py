"""Opening an input so that it opens nothing but itself.

A media file may be a script: a playlist, a concat list, a session description. Read by a multimedia
library these open other files and addresses of the writer's choosing. Such formats are refused, and a
file input may use no protocol but ``file``.
"""

from __future__ import annotations

import errno
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

import av
import av.container

from ..errors import InputError

# Formats that name other files, or that are no file at all.
_SCRIPTS = {
    *("concat", "dash", "hls", "imf", "webm_dash_manifest", "sdp", "sap", "rtsp", "rtp", "vobsub"),
    *("image2", "image2pipe", "alias_pix", "brender_pix", "lavfi", "ffmetadata"),
    # Text and text-mode pictures, which any file without a better explanation may be taken for.
    *("tty", "bin", "adf", "idf", "xbin"),
}
# How such a file begins, to tell a script from a file that is merely broken.
_SCRIPT_STARTS = (b"#EXTM3U", b"ffconcat version", b"v=0\r", b"v=0\n")

# A frame of more pixels than this is refused before it is decoded (16384 px a side, squared).
MAX_SIDE = 16384
_LIMITS = {"max_pixels": str(MAX_SIDE * MAX_SIDE)}


class Readable(Protocol):
    """What a pipe offers: bytes as they come, and empty bytes at the end."""

    def read(self, size: int) -> bytes:
        """Read up to ``size`` bytes."""
        ...


def open_input(
    source: str | Readable,
    name: str,
    allow_protocols: Sequence[str] = (),
    probe: bool = True,
) -> av.container.InputContainer:
    """Open a media file by path, or a readable binary file object such as a pipe.

    ``name`` is what messages call it. ``allow_protocols`` names protocols that playlists may use after all;
    with any named, scripts are read. ``probe`` decodes the first frames, to learn of each stream what its
    container does not tell: that takes a while. Raises InputError, in one line, for a missing, empty or
    unreadable file and for a script.
    """
    if isinstance(source, str):
        _check_file(source, name)
    options = dict(_LIMITS)
    if allow_protocols:
        options["protocol_whitelist"] = ",".join(("file", *allow_protocols))
    else:
        options["protocol_whitelist"] = "file" if isinstance(source, str) else ""
        options["format_whitelist"] = ",".join(sorted(av.formats_available - _SCRIPTS))
    if not probe:
        options["codec_whitelist"] = "none"  # for the probing alone
    target = "file:" + source if isinstance(source, str) else source
    try:
        return av.open(
            target,
            mode="r",
            options=options,
            metadata_errors="replace",
            buffer_size=1 << 20,
        )
    except av.error.FFmpegError as error:
        if isinstance(source, str) and _is_script(Path(source)):
            raise InputError(
                f"{name}: is a playlist or script that names other files; give those files themselves,"
                " or allow their protocol with --allow-protocol"
            ) from error
        what = reason(error)
        if isinstance(source, str) and _is_mp4(Path(source)):
            what = (
                "it is damaged, or breaks off before its index, without which an MP4 or MOV is lost"
            )
        raise InputError(f"{name}: cannot be read as a video ({what})") from error


def reason(error: BaseException) -> str:
    """Say why a media operation failed, in a few words."""
    if isinstance(error, av.error.InvalidDataError):
        return "the data is damaged or of no known format"
    text = getattr(error, "strerror", None) or str(error) or type(error).__name__
    return text[0].lower() + text[1:]


def _check_file(path: str, name: str) -> None:
    """Tell apart what libav would report as one and the same."""
    try:
        size = os.stat(path).st_size
    except OSError as error:
        what = "no such file: check its name" if error.errno == errno.ENOENT else error.strerror
        if "://" in path:
            what = "is an address: read it with --live, or save it to a file first"
        raise InputError(f"{name}: {what}") from error
    if Path(path).is_dir():
        raise InputError(f"{name}: is a directory, not a video")
    if Path(path).is_file() and size == 0:
        raise InputError(f"{name}: the file is empty: take another copy of it")
    if not os.access(path, os.R_OK):
        raise InputError(f"{name}: permission denied")


def _is_mp4(path: Path) -> bool:
    with path.open("rb") as file:
        return file.read(8)[4:] == b"ftyp"


def _is_script(path: Path) -> bool:
    with path.open("rb") as file:
        head = file.read(4096)
    return head.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(_SCRIPT_STARTS) or b"<MPD" in head
