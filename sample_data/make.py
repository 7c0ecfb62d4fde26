"""Make the samples anew, here: the same bytes each time on one machine. ``make sample-data`` runs this."""

from __future__ import annotations

from pathlib import Path

from endocal.jobs.synth import synth_clip, synth_zoom
from endocal.jobs.synth_scenes import ClipSpec, ZoomSpec

HERE = Path(__file__).resolve().parent
ZOOMS = (1.0, 1.22, 1.5, 1.8)


def main() -> None:
    """Write boards, clip and truths beside this file."""
    boards = ZoomSpec(zooms=ZOOMS, size=(720, 540), noise=1.5, seed=1)
    synth_zoom(boards, str(HERE), overwrite=True)
    # The same lens, recorded smaller; up through the settings, a rest, and back.
    clip = ClipSpec(
        zooms=(*ZOOMS, ZOOMS[-1], ZOOMS[0]), size=(640, 480), duration=5.0, noise=1.2, seed=2
    )
    synth_clip(clip, str(HERE / "clip.mp4"), overwrite=True)


if __name__ == "__main__":
    main()
