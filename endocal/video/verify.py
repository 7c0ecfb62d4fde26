"""Looking at a finished file with a reader's eyes, before it gets its name."""

from __future__ import annotations

import av

from ..errors import InputError, OutputError
from .access import open_input

# A file may be so much longer or shorter than the sum of its frames, s: the last frame's own duration is
# written differently from container to container.
_TOLERANCE_S = 0.5


def verify_video(path: str, name: str, frames: int, seconds: float | None) -> None:
    """Check that a video file holds so many frames and lasts so long, as far as its headers tell.

    ``seconds`` from the first frame's start to the last one's end; None: not known. ``name`` is what
    messages call the file. Raises OutputError where it does not.
    """
    try:
        container = open_input(path, name)
    except InputError as error:
        raise OutputError(f"{name}: came out unreadable ({error})") from error
    with container:
        if not container.streams.video:
            raise OutputError(f"{name}: came out without its video")
        stream = container.streams.video[0]
        if stream.frames and (
            stream.frames < frames or (seconds is not None and stream.frames > frames)
        ):
            raise OutputError(
                f"{name}: {stream.frames} of {frames} frames came out; is the disk sound?"
            )
        if seconds is None or not container.duration:
            return
        whole = container.duration / av.time_base
        own = (
            float(stream.duration * stream.time_base)
            if stream.duration and stream.time_base
            else None
        )
        if whole < seconds - _TOLERANCE_S or (own is not None and own > seconds + _TOLERANCE_S):
            raise OutputError(
                f"{name}: came out {own if own is not None else whole:.2f} s long instead of {seconds:.2f} s"
            )
