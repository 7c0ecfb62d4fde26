"""Whether a suffix names a container for video, before anything is written into it."""

from __future__ import annotations

import av

from ..errors import UsageError
from .container import ContainerKind
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
