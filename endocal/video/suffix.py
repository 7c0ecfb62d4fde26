"""Whether a suffix names a container for video, and which, before anything is written into it."""

from __future__ import annotations

import av

from ..errors import UsageError
from .container import MOV_FAMILY, ContainerKind
from .encoder import EncoderChoice, encoders_for


def check_suffix(suffix: str, choice: EncoderChoice) -> None:
    """Raise UsageError for a suffix (.mkv) that names no video file, or one for no such encoder's video."""
    try:
        container = av.open(f"file:x{suffix}", mode="w")
    except ValueError:
        container = None
    # Numbered pictures, playlists and devices choose files of their own.
    if container is None or container.format.no_file:
        raise UsageError(
            f"--suffix {suffix}: names no video file; use one such as .mp4, .mkv, .mov or .avi"
        )
    kind = ContainerKind(container.format.name)
    container.close()
    if not any(kind.takes_codec(name) for name in encoders_for(choice)):
        video = "video" if choice.codec is None else f"video of {choice.codec}"
        raise UsageError(f"--suffix {suffix}: {kind.shown} takes no {video}; use one such as .mkv")


def check_named(suffix: str, container: str, name: str) -> None:
    """Raise UsageError where a suffix (.mp4) names another container than the one of FFmpeg's name.

    ``name`` is what messages call the file.
    """
    try:
        with av.open(f"file:x{suffix}", mode="w") as file:
            own = file.format.name
    except ValueError:
        return  # it names none
    if own != container and not {own, container} <= MOV_FAMILY:
        given = ContainerKind(container).shown
        raise UsageError(
            f"{name}: its suffix names {ContainerKind(own).shown}, and --format {given}: leave one out"
        )
