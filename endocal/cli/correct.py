"""``endocal correct``: a video or a picture without its lens distortion."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..errors import UsageError
from .options import Device, Json, Output, Overwrite, note, parse_size, print_json
from .progress import progress_bar

if TYPE_CHECKING:
    from ..jobs.correct import CorrectionReport

EXAMPLES = (
    "endocal correct surgery.mp4 -o corrected.mp4 -c zoom.toml",
    "endocal correct frame.png -o corrected.png -c cal.toml --view full",
    "ffmpeg -i in.avi -f yuv4mpegpipe - | endocal correct - -o - -c zoom.toml | ffplay -",
)


def _picture(*names: str, help: str) -> Any:
    return typer.Option(*names, help=help, rich_help_panel="Picture")


def _encoding(*names: str, metavar: str, help: str) -> Any:
    return typer.Option(*names, metavar=metavar, help=help, rich_help_panel="Encoding")


def _files(*names: str, help: str) -> Any:
    return typer.Option(*names, help=help, rich_help_panel="Files and streams")


Interpolation = Annotated[str, _picture(help="nearest, bilinear, bicubic or lanczos.")]
View = Annotated[
    str, _picture(help="same: centre at its own scale; crop: no blank pixel; full: all content.")
]
Size = Annotated[str | None, _picture(help="Output size, WIDTHxHEIGHT in px.")]
Scale = Annotated[float | None, _picture(help="Magnification of the output.")]
KeepSar = Annotated[bool, _picture("--keep-sar", help="Keep pixels that are not square.")]
SideBySide = Annotated[bool, _picture("--side-by-side", help="Original left, corrected right.")]
Stereo = Annotated[
    str | None,
    _picture(help="Two eyes in a frame: sbs (side by side) or tb (one below the other)."),
]
Deinterlace = Annotated[str, _picture(help="auto, off, frame (same rate), field (double rate).")]
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
Container = Annotated[
    str | None,
    _encoding("--format", metavar="NAME", help="Container of a pipe: y4m, matroska, mpegts."),
]
Lookup = Annotated[str, _picture(help="How a zoom table is read: auto, diameter, area.")]
AssumeDiameter = Annotated[
    float | None,
    _picture("--assume-diameter", help="Diameter of the visible circle, px, until one is seen."),
]
ZoomLog = Annotated[
    str | None, _files("--zoom-log", help="Write the zoom of each frame here (.csv or .jsonl).")
]
ZoomFrom = Annotated[
    str | None, _files("--zoom-from", help="Take each frame's zoom from such a file.")
]
StripMetadata = Annotated[
    bool, _files("--strip-metadata", help="Drop metadata, chapters, attachments, data streams.")
]
AllowProtocol = Annotated[
    list[str] | None, _files("--allow-protocol", help="Let a playlist open this protocol.")
]
Live = Annotated[
    bool,
    _files("--live", help="INPUT is an address (rtsp://, udp://, …) or /dev/video0; never queue."),
]
Strict = Annotated[bool, _files("--strict", help="Fail where the input is damaged.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Say nothing on stderr but errors.")]


Configs = Annotated[
    list[Path],
    typer.Option(
        *("--config", "-c"),
        metavar="FILE",
        help="A calibration or zoom table; - is stdin. Twice for the two eyes of --stereo.",
    ),
]


def command(
    source: Annotated[
        str, typer.Argument(metavar="INPUT", help="A video or a picture; - is stdin.")
    ],
    output: Output,
    config: Configs,
    view: View = "same",
    size: Size = None,
    scale: Scale = None,
    interpolation: Interpolation = "bilinear",
    keep_sar: KeepSar = False,
    side_by_side: SideBySide = False,
    stereo: Stereo = None,
    deinterlace: Deinterlace = "auto",
    lookup: Lookup = "auto",
    assume_diameter: AssumeDiameter = None,
    device: Device = "auto",
    codec: Codec = None,
    crf: Crf = None,
    preset: Preset = None,
    pix_fmt: PixFmt = None,
    codec_option: CodecOption = None,
    container: Container = None,
    zoom_log: ZoomLog = None,
    zoom_from: ZoomFrom = None,
    strip_metadata: StripMetadata = False,
    allow_protocol: AllowProtocol = None,
    live: Live = False,
    overwrite: Overwrite = False,
    strict: Strict = False,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Correct the lens distortion of a video or a picture, and keep all else as it is."""
    from ..jobs.correct import PIPE, CorrectionSpec, correct
    from ..video.encoder import EncoderChoice

    if len(config) > 2:
        raise UsageError("--config is given once, or twice for the two eyes of --stereo")
    if json and str(output) == PIPE:
        raise UsageError("--json and -o - both write to stdout: name an output file")
    spec = CorrectionSpec(
        input=source,
        output=str(output),
        calibration=str(config[0]),
        right_calibration=str(config[1]) if len(config) > 1 else None,
        stereo=stereo,
        view=view,
        size=parse_size(size),
        scale=scale,
        interpolation=interpolation,
        device=device,
        keep_sar=keep_sar,
        side_by_side=side_by_side,
        deinterlace=deinterlace,
        encoder=EncoderChoice(codec, crf, preset, pix_fmt, _pairs(codec_option or [])),
        container_format=container,
        lookup=lookup,
        assume_diameter=assume_diameter,
        zoom_log=zoom_log,
        zoom_from=zoom_from,
        overwrite=overwrite,
        strict=strict,
        live=live,
        strip_metadata=strip_metadata,
        allow_protocols=tuple(allow_protocol or ()),
    )
    with progress_bar(source, quiet) as progress:
        report = correct(spec, progress)
    if json:
        print_json(dataclasses.asdict(report))
    if not quiet:
        _tell(report)


def _pairs(items: list[str]) -> dict[str, str]:
    pairs = {}
    for item in items:
        key, equals, value = item.partition("=")
        if not (key and equals):
            raise UsageError(f"--codec-option {item}: write KEY=VALUE")
        pairs[key] = value
    return pairs


def _tell(report: CorrectionReport) -> None:
    """Say on standard error what was done, and what was odd about it."""
    for text in report.notes:
        note(f"note: {text}")
    for text in report.warnings:
        note(f"warning: {report.input}: {text}")
    w, h = report.size_out
    if report.codec is None:
        note(f"{report.output}: picture of {w}x{h} on {report.device}")
        return
    if report.latency is not None:
        late = report.latency
        note(
            f"latency {late.median:.0f} ms, {late.most:.0f} ms at most;"
            f" {late.dropped} frames left out to keep up"
        )
    rate = report.frames / report.seconds if report.seconds else 0.0
    note(
        f"{report.output}: {report.frames} frames of {w}x{h}, {report.codec}, in {report.seconds:.1f} s"
        f" ({rate:.0f} fps) on {report.device}"
    )
