"""Make pictures and clips with known truth: the jobs behind ``endocal synth``."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Collection, Iterator
from contextlib import ExitStack
from pathlib import Path

from ..calibration.result import Calibration
from ..errors import OutputError, UsageError
from ..files import atomic_output, dumps, encode_image
from ..files.names import shown
from ..synth.board import BoardScene, render_board
from ..synth.camera import Picture
from ..synth.clip import clip_frames
from ..synth.sound import RATE as SOUND_RATE
from ..synth.sound import sound_track
from ..zoom.table import ZoomTable
from .correction import Progress
from .synth_scenes import ClipSpec, ZoomSpec, clip_scene, zoom_scene
from .synth_truth import HEADER, frame_row, lens_truth, true_calibration


def synth_board(scene: BoardScene, output: str, overwrite: bool = False) -> Calibration:
    """Render one picture and write it with its truth (``NAME.truth.toml``); return that truth."""
    truth = true_calibration(scene)
    with ExitStack() as outputs:
        place = _outputs(outputs, [output, truth_name(output, ".toml")], overwrite)
        place[0].write_bytes(_encoded(render_board(scene), output))
        place[1].write_text(dumps(truth), encoding="utf-8")
    return truth


def synth_zoom(spec: ZoomSpec, folder: str, overwrite: bool = False) -> list[str]:
    """Render a board at each zoom into ``folder``, which is made if need be; return the pictures' names.

    Each ``board-N.png`` has its truth beside it; ``zoom.truth.toml`` is the whole lens's.
    """
    if len(set(spec.zooms)) < max(len(spec.zooms), 2):
        raise UsageError("--zooms: two different zooms at least, none twice")
    place = Path(folder)
    try:
        place.mkdir(exist_ok=True)
    except OSError as error:
        raise OutputError(f"{shown(folder)}: cannot be made: {error.strerror}") from None
    pictures = [str(place / f"board-{i}.png") for i in range(1, len(spec.zooms) + 1)]
    scenes = [zoom_scene(spec, i) for i in range(len(spec.zooms))]
    truths: dict[str, Calibration | ZoomTable] = {
        truth_name(p, ".toml"): true_calibration(s) for p, s in zip(pictures, scenes, strict=True)
    }
    truths[str(place / "zoom.truth.toml")] = lens_truth(spec)
    with ExitStack() as outputs:
        images = _outputs(outputs, pictures, overwrite)
        texts = _outputs(outputs, truths, overwrite)
        for path, scene in zip(images, scenes, strict=True):
            path.write_bytes(_encoded(render_board(scene), path.name))
        for path, truth in zip(texts, truths.values(), strict=True):
            path.write_text(dumps(truth), encoding="utf-8")
    return pictures


def synth_clip(
    spec: ClipSpec,
    output: str,
    overwrite: bool = False,
    progress: Callable[[Progress], None] | None = None,
) -> int:
    """Render and encode a clip; return how many frames it has.

    Beside it go ``NAME.truth.csv``, a row per frame, and ``NAME.truth.toml``, the lens at the clip's zooms.
    ``progress`` is called in this thread after each frame.
    """
    from ..video.compose import compose

    scene = clip_scene(spec)
    rows = [HEADER]

    def pictures() -> Iterator[Picture]:
        start = time.monotonic()
        for frame in clip_frames(scene):
            rows.append(frame_row(frame))
            yield frame.image
            if progress is not None:
                progress(Progress(frame.index + 1, scene.frames, time.monotonic() - start))

    names = [output, truth_name(output, ".csv"), truth_name(output, ".toml")]
    with ExitStack() as outputs:
        video, table, lens = _outputs(outputs, names, overwrite)
        sound = sound_track(spec.sound, float(spec.frames / spec.rate))
        count = compose(
            str(video), pictures(), spec.size, spec.rate, sound, SOUND_RATE, spec.crf, output
        )
        table.write_text("\n".join(rows) + "\n", encoding="utf-8")
        lens.write_text(dumps(lens_truth(spec)), encoding="utf-8")
    return count


def truth_name(output: str, suffix: str) -> str:
    """Return the name of the truth beside an output: ``board.png`` has ``board.truth.toml``."""
    return os.path.splitext(output)[0] + ".truth" + suffix


def _outputs(stack: ExitStack, names: Collection[str], overwrite: bool) -> list[Path]:
    """Open all outputs before anything is rendered; they appear together, or not at all."""
    if "-" in names:
        raise UsageError("the truth is written beside the output: name a file instead of -")
    return [stack.enter_context(atomic_output(name, overwrite)) for name in names]


def _encoded(picture: Picture, name: str) -> bytes:
    return encode_image(picture, os.path.splitext(name)[1])
