"""The options of a correction, each written once, and commands that take all of them."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

from ..errors import UsageError
from ..jobs.threads import limit_threads
from .options import VIEWS, Device, choices, parse_size


def _picture(
    *names: str,
    help: str,
    metavar: str | None = None,
    values: Callable[[str], list[str]] | None = None,
) -> Any:
    return typer.Option(
        *names, metavar=metavar, help=help, autocompletion=values, rich_help_panel="Picture"
    )


def _encoding(*names: str, metavar: str, help: str) -> Any:
    return typer.Option(*names, metavar=metavar, help=help, rich_help_panel="Encoding")


def file_option(*names: str, help: str, metavar: str | None = None) -> Any:
    """Return an option that is shown among those about files and streams."""
    return typer.Option(*names, help=help, metavar=metavar, rich_help_panel="Files and streams")


Interpolation = Annotated[
    str,
    _picture(
        metavar="NAME",
        values=choices("nearest", "bilinear", "bicubic", "lanczos"),
        help="nearest, bilinear, bicubic or lanczos.",
    ),
]
View = Annotated[
    str,
    _picture(
        metavar="NAME",
        values=VIEWS,
        help="same: centre at its own scale; crop: no blank pixel; full: all content.",
    ),
]
Size = Annotated[str | None, _picture(metavar="WxH", help="Output size, px.")]
Scale = Annotated[float | None, _picture(metavar="S", help="Magnification of the output.")]
KeepSar = Annotated[bool, _picture("--keep-sar", help="Keep pixels that are not square.")]
SideBySide = Annotated[bool, _picture("--side-by-side", help="Original left, corrected right.")]
Stereo = Annotated[
    str | None,
    _picture(
        metavar="NAME",
        values=choices("sbs", "tb"),
        help="Two eyes in a frame: sbs (side by side) or tb (one below the other).",
    ),
]
Deinterlace = Annotated[
    str,
    _picture(
        metavar="MODE",
        values=choices("auto", "off", "frame", "field"),
        help="auto, off, frame (same rate), field (double rate).",
    ),
]
Codec = Annotated[str | None, _encoding(metavar="NAME", help="Encoder; else the source's kind.")]
Crf = Annotated[
    float | None, _encoding(metavar="N", help="Constant quality; else visually lossless.")
]
Preset = Annotated[str | None, _encoding(metavar="NAME", help="The encoder's preset.")]
PixFmt = Annotated[
    str | None, _encoding("--pix-fmt", metavar="NAME", help="Pixel format; else the source's.")
]
CodecOption = Annotated[
    list[str] | None,
    _encoding("--codec-option", metavar="KEY=VALUE", help="For the encoder; may be repeated."),
]
Lookup = Annotated[
    str,
    _picture(
        metavar="NAME",
        values=choices("auto", "diameter", "area"),
        help="How a zoom table is read: auto, diameter, area.",
    ),
]
Center = Annotated[
    str,
    _picture(
        metavar="NAME",
        values=choices("auto", "follow", "fixed"),
        help="follow: the centre goes with the visible circle; fixed; auto: follow with a zoom table.",
    ),
]
AssumeDiameter = Annotated[
    float | None,
    _picture(
        "--assume-diameter",
        metavar="D",
        help="Diameter of the visible circle, px, until one is seen.",
    ),
]
StripMetadata = Annotated[
    bool,
    file_option("--strip-metadata", help="Drop metadata, chapters, attachments, data streams."),
]
AllowProtocol = Annotated[
    list[str] | None,
    file_option("--allow-protocol", metavar="NAME", help="Let a playlist open this protocol."),
]
Strict = Annotated[bool, file_option("--strict", help="Fail where the input is damaged.")]
Configs = Annotated[
    list[Path],
    typer.Option(
        *("--config", "-c"),
        metavar="FILE",
        help="A calibration or zoom table; - is stdin. Twice for the two eyes of --stereo.",
    ),
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Say nothing on stderr but errors.")]


def correction(
    view: View = "same",
    size: Size = None,
    scale: Scale = None,
    interpolation: Interpolation = "bilinear",
    keep_sar: KeepSar = False,
    side_by_side: SideBySide = False,
    stereo: Stereo = None,
    deinterlace: Deinterlace = "auto",
    lookup: Lookup = "auto",
    center: Center = "auto",
    assume_diameter: AssumeDiameter = None,
    device: Device = "auto",
    codec: Codec = None,
    crf: Crf = None,
    preset: Preset = None,
    pix_fmt: PixFmt = None,
    codec_option: CodecOption = None,
    strip_metadata: StripMetadata = False,
    allow_protocol: AllowProtocol = None,
    strict: Strict = False,
) -> dict[str, Any]:
    """Return the options' values as fields of CorrectionSpec."""
    from ..video.encoder import EncoderChoice

    return {
        "view": view,
        "size": parse_size(size),
        "scale": scale,
        "interpolation": interpolation,
        "keep_sar": keep_sar,
        "side_by_side": side_by_side,
        "stereo": stereo,
        "deinterlace": deinterlace,
        "lookup": lookup,
        "center": center,
        "assume_diameter": assume_diameter,
        "device": device,
        "encoder": EncoderChoice(codec, crf, preset, pix_fmt, _pairs(codec_option or [])),
        "strip_metadata": strip_metadata,
        "allow_protocols": tuple(allow_protocol or ()),
        "strict": strict,
    }


def takes_correction(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command the options of ``correction`` in the place of its parameter ``fields``.

    The command gets there what ``correction`` makes of them. Libraries are told its ``threads``.
    """
    options = inspect.signature(correction, eval_str=True).parameters
    parameters: list[inspect.Parameter] = []
    for own in inspect.signature(command, eval_str=True).parameters.values():
        parameters += options.values() if own.name == "fields" else [own]

    @functools.wraps(command)
    def with_options(**values: Any) -> None:
        limit_threads(values.get("threads") or 0)
        fields = correction(**{name: values.pop(name) for name in options})
        command(fields=fields, **values)

    by_name = [p.replace(kind=inspect.Parameter.KEYWORD_ONLY) for p in parameters]
    with_options.__signature__ = inspect.Signature(by_name)  # type: ignore[attr-defined]
    with_options.__annotations__ = {p.name: p.annotation for p in parameters}
    return with_options


def parse_configs(config: list[Path]) -> tuple[str, str | None]:
    """Return the calibration, and the second eye's where it has one; UsageError for more than two."""
    if len(config) > 2:
        raise UsageError("--config is given once, or twice for the two eyes of --stereo")
    return str(config[0]), str(config[1]) if len(config) > 1 else None


def _pairs(items: list[str]) -> dict[str, str]:
    pairs = {}
    for item in items:
        key, equals, value = item.partition("=")
        if not (key and equals):
            raise UsageError(f"--codec-option {item}: write KEY=VALUE")
        pairs[key] = value
    return pairs
