"""``endocal synth``: pictures and clips with known truth."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Annotated, Any

import typer

from ..errors import UsageError
from .options import Json, Overwrite, choices, note, parse_numbers, parse_size, print_json
from .progress import progress_bar

EXAMPLES = (
    "endocal synth board -o board.png",
    "endocal synth zoom -o boards --zooms 1,1.5,2",
    "endocal synth clip -o clip.mp4 --scene tissue --zooms 1,2.5,2.5,1 --duration 20",
)

group = typer.Typer(
    no_args_is_help=True, help="Make pictures and clips whose distortion is known exactly."
)


def _option(
    help: str,
    metavar: str | None = None,
    name: str | None = None,
    values: Callable[[str], list[str]] | None = None,
) -> Any:
    return typer.Option(
        *([name] if name else []), metavar=metavar, help=help, autocompletion=values
    )


Output = Annotated[Path, typer.Option("--output", "-o", metavar="FILE", help="Where to write.")]
Size = Annotated[str | None, _option("Picture size in px.", "WxH")]
Squares = Annotated[str | None, _option("Squares of the board, columns and rows.", "WxH")]
Zooms = Annotated[str | None, _option("Zoom settings; 1 is the widest.", "Z,Z,...")]
Strength = Annotated[float | None, _option("lambda * diameter^2, at each zoom the same.")]
Fill = Annotated[float | None, _option("Circle diameter over frame height at zoom 1.")]
Noise = Annotated[float | None, _option("Sigma of the noise, in grey levels.")]
Seed = Annotated[int, typer.Option(min=0, help="The same seed gives the same bytes.")]


@group.command("board")
def board(
    output: Output,
    size: Size = None,
    lam: Annotated[
        float | None, _option("Distortion, px^-2; below 0 barrel.", name="--lambda")
    ] = None,
    center: Annotated[str | None, _option("Distortion centre in px.", "X,Y")] = None,
    diameter: Annotated[float | None, _option("Of the content circle, px; 0 for none.")] = None,
    pattern: Annotated[
        str | None, _option("chessboard or lines.", "NAME", values=choices("chessboard", "lines"))
    ] = None,
    squares: Squares = None,
    tilt: Annotated[float | None, _option("Tilt of the board, degrees.")] = None,
    rotation: Annotated[float | None, _option("Turn of the board in its plane, degrees.")] = None,
    share: Annotated[float | None, _option("How much of the view the pattern covers.")] = None,
    blur: Annotated[float | None, _option("Sigma of the blur, px.")] = None,
    noise: Noise = None,
    vignetting: Annotated[float | None, _option("Share of light lost at the rim.")] = None,
    gamma: Annotated[float | None, _option("Grey level is light^(1/gamma).")] = None,
    jpeg: Annotated[int | None, _option("Pass through JPEG of this quality.", "1-100")] = None,
    random: Annotated[bool, typer.Option("--random", help="Draw all of that by the seed.")] = False,
    seed: Seed = 0,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Render a board, and its truth as a calibration beside it."""
    from ..jobs.synth import synth_board, truth_name
    from ..jobs.synth_scenes import BoardSpec, board_scene
    from ..synth.random import random_board

    given = _given(
        size=parse_size(size),
        lam=lam,
        center=parse_numbers(center, "--center", 2),
        diameter=diameter,
        pattern=pattern,
        squares=parse_size(squares),
        tilt=tilt,
        rotation=rotation,
        share=share,
        blur=blur,
        noise=noise,
        vignetting=vignetting,
        gamma=gamma,
        jpeg=jpeg,
    )
    if random and given:
        raise UsageError("--random draws everything: give it --seed alone")
    scene = random_board(seed) if random else board_scene(BoardSpec(**given, seed=seed))
    truth = synth_board(scene, str(output), overwrite)
    model, circle = truth.model, truth.boundary
    _tell(
        json,
        str(output),
        truth_name(str(output), ".toml"),
        {
            "lambda": model.lam,
            "center": list(model.center),
            "size": list(model.size),
            "diameter": circle.diameter if circle else None,
        },
    )


@group.command("zoom")
def zoom(
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="DIR", help="Folder for the pictures.")
    ],
    zooms: Zooms = None,
    size: Size = None,
    strength: Strength = None,
    fill: Fill = None,
    squares: Squares = None,
    noise: Noise = None,
    seed: Seed = 0,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Render boards at several zooms of one lens, and their truth as a zoom table."""
    from ..jobs.synth import synth_zoom
    from ..jobs.synth_scenes import ZoomSpec

    spec = ZoomSpec(**_lens_options(zooms, size, strength, fill, squares, noise), seed=seed)
    pictures = synth_zoom(spec, str(output), overwrite)
    _tell(json, str(output), str(output / "zoom.truth.toml"), {"pictures": pictures})


@group.command("clip")
def clip(
    output: Output,
    zooms: Zooms = None,
    duration: Annotated[float | None, _option("Length in s.")] = None,
    fps: Annotated[str | None, _option("Frames per second: 25 or 30000/1001.", "RATE")] = None,
    size: Size = None,
    scene: Annotated[
        str | None,
        _option("board (before tissue) or tissue.", "NAME", values=choices("board", "tissue")),
    ] = None,
    strength: Strength = None,
    fill: Fill = None,
    squares: Squares = None,
    instruments: Annotated[int | None, _option("How many move about.")] = None,
    motion: Annotated[float | None, _option("Sway of the hand: 1 usual, 0 still.")] = None,
    approach: Annotated[
        float | None, _option("Part of the distance that the lens goes to the tissue and back.")
    ] = None,
    play: Annotated[
        float | None, _option("How far the picture wanders on the sensor, px: a loose coupler.")
    ] = None,
    noise: Noise = None,
    sound: Annotated[str | None, _option("sweep, clicks or none.", "NAME")] = None,
    crf: Annotated[float | None, _option("Constant quality of the H.264 encoder.")] = None,
    seed: Seed = 0,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Render a clip that zooms, and the truth of each frame."""
    from ..jobs.synth import synth_clip, truth_name
    from ..jobs.synth_scenes import ClipSpec

    spec = ClipSpec(
        **_lens_options(zooms, size, strength, fill, squares, noise),
        **_given(
            duration=duration,
            rate=_rate(fps),
            scene=scene,
            instruments=instruments,
            motion=motion,
            approach=approach,
            play=play,
            sound=sound,
            crf=crf,
        ),
        seed=seed,
    )
    with progress_bar(str(output)) as progress:
        frames = synth_clip(spec, str(output), overwrite, progress)
    _tell(json, str(output), truth_name(str(output), ".csv"), {"frames": frames})


def _lens_options(
    zooms: str | None,
    size: str | None,
    strength: float | None,
    fill: float | None,
    squares: str | None,
    noise: float | None,
) -> dict[str, Any]:
    return _given(
        zooms=parse_numbers(zooms, "--zooms", zooms.count(",") + 1) if zooms else None,
        size=parse_size(size),
        strength=strength,
        fill=fill,
        squares=parse_size(squares),
        noise=noise,
    )


def _given(**options: Any) -> dict[str, Any]:
    """Leave out what was not given, so that the specs' own defaults hold."""
    return {name: value for name, value in options.items() if value is not None}


def _rate(value: str | None) -> Fraction | None:
    try:
        return Fraction(value) if value is not None else None
    except (ValueError, ZeroDivisionError):
        raise UsageError(f"--fps {value!r}: write 25, 29.97 or 30000/1001") from None


def _tell(json: bool, output: str, truth: str, details: dict[str, Any]) -> None:
    if json:
        print_json({"output": output, "truth": truth, **details})
    note(f"{output}, with its truth in {truth}")
