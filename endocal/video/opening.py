"""Opening an encoder, and saying why it refuses."""

from __future__ import annotations

import os
import re

import av
import av.logging

from ..errors import OutputError, UsageError
from .access import reason
from .encoder import EncoderChoice
from .messages import heard

# Encoders that take whole chroma samples only; what libx265 says of others helps nobody.
_WHOLE_CHROMA = ("libx264", "libx265")
# What an encoder says of a parameter that it does not take, though it opens all the same.
_IGNORED = re.compile(r"error parsing option|unknown option|invalid value for", re.IGNORECASE)
# x264 says what it thinks of these past every log setting of the library.
_X264_NAMES = {
    "profile": ("baseline", "main", "high", "high10", "high422", "high444"),
    "tune": (
        *("film", "animation", "grain", "stillimage", "psnr", "ssim"),
        *("fastdecode", "zerolatency"),
    ),
}
# SVT-AV1's own setting for what it prints: errors alone.
_QUIET_SVT = ("SVT_LOG", "1")


def open_encoder(
    context: av.VideoCodecContext, choice: EncoderChoice, name: str, asked_size: bool
) -> None:
    """Open an encoder that has been set up for ``choice``; ``name`` is what messages call the output.

    Raises UsageError for an option that it does not take, and for a size, if one was asked for, that it
    does not take; OutputError where it refuses for another reason.
    """
    _check_size(context, name, asked_size)
    if context.name.startswith("libx264"):
        _check_x264(choice)
    os.environ.setdefault(*_QUIET_SVT)
    messages: list[tuple[int, str, str]] = []
    try:
        with heard(av.logging.WARNING) as messages:
            context.open()
    except av.error.FFmpegError as error:
        why = messages[-1][2].strip().rstrip(".") if messages else reason(error)
        values = (*choice.options.values(), choice.preset)
        if any(value and value in why for value in values):
            raise UsageError(f"{context.name} does not take that: {why}") from error
        raise OutputError(
            f"{name}: {context.name} refuses frames of {context.width}x{context.height}"
            f" {context.pix_fmt}: {why}"
        ) from error
    if context.options:
        unknown = ", ".join(context.options)
        raise UsageError(f"--codec-option {unknown}: {context.name} has no such option")
    for _, _, message in messages:
        if choice.options and _IGNORED.match(message):
            raise UsageError(f"--codec-option: {context.name}: {message.strip().rstrip('.')}")


def _check_size(context: av.VideoCodecContext, name: str, asked: bool) -> None:
    if not context.name.startswith(_WHOLE_CHROMA):
        return
    pix_fmt = context.pix_fmt or ""
    size = context.width, context.height
    chroma = next((c for c in av.VideoFormat(pix_fmt, 16, 16).components if c.is_chroma), None)
    steps = (1, 1) if chroma is None else (16 // chroma.width, 16 // chroma.height)
    whole = tuple(max(n - n % step, step) for n, step in zip(size, steps, strict=True))
    if whole == size:
        return
    error = UsageError if asked else OutputError
    raise error(
        f"{name}: {context.name} does not take {size[0]}x{size[1]} frames in {pix_fmt}: give"
        f" --size {whole[0]}x{whole[1]}, --pix-fmt yuv444p, or another --codec"
    )


def _check_x264(choice: EncoderChoice) -> None:
    for option, known in _X264_NAMES.items():
        for word in re.split(r"[,./+-]", choice.options.get(option, known[0])):
            if word not in known:
                raise UsageError(f"--codec-option {option}={word}: libx264 has {', '.join(known)}")
