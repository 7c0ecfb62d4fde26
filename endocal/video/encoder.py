"""Which encoder, pixel format and options come closest to the source."""

from __future__ import annotations

from dataclasses import dataclass, field

import av

from ..errors import OutputError, UsageError
from .container import ContainerKind
from .stream import HdrMetadata, StreamInfo

# The encoder of the source's own family, where it is worth having.
_FAMILY = {
    "h264": "libx264",
    "hevc": "libx265",
    "vp9": "libvpx-vp9",
    "av1": "libsvtav1",
    "ffv1": "ffv1",
    "prores": "prores_ks",
    "mjpeg": "mjpeg",
    "rawvideo": "rawvideo",
    "vp8": "libvpx-vp9",
    # Screen captures and intermediates.
    **{name: name for name in ("huffyuv", "ffvhuff", "utvideo", "qtrle", "png", "v210")},
}
# What loses nothing is to lose nothing on, in containers that are for keeping.
_LOSSLESS = (
    "ffv1",
    "rawvideo",
    "huffyuv",
    "ffvhuff",
    "utvideo",
    "qtrle",
    "png",
    "apng",
    "v210",
    "gif",
)
_ARCHIVES = ("matroska", "mov", "avi", "nut")
# Tried in this order where the family's encoder has no such pixel format or the container refuses it.
_FALLBACKS = ("libx264", "libx264rgb", "libx265", "libvpx-vp9", "libsvtav1", "ffv1", "rawvideo")

# Visually lossless by default. What each encoder calls its constant quality, and its value for that.
_QUALITY: dict[str, tuple[str, float]] = {
    "libx264": ("crf", 17.0),
    "libx264rgb": ("crf", 17.0),
    "libx265": ("crf", 19.0),
    "libvpx-vp9": ("crf", 20.0),
    "libsvtav1": ("crf", 20.0),
}
_CRF_LIMIT = {"libx264": 51, "libx264rgb": 51, "libx265": 51, "libvpx-vp9": 63, "libsvtav1": 63}
# The encoders say nothing useful about a preset that they do not know, and one of them on stderr.
_X26_PRESETS = (
    *("ultrafast", "superfast", "veryfast", "faster", "fast", "medium"),
    *("slow", "slower", "veryslow", "placebo"),
)
_WITH_PRESETS = ("libx26", "libsvtav1", "h264_", "hevc_", "av1_")
# Unless a preset is asked for: quick enough to keep up with surgery video, and slim. Every frame that x264
# looks ahead takes 14 MB at 1080p; this keeps the whole job under 350 MiB there, for a sixth more bytes.
_X264 = {"preset": "veryfast", "bf": "0", "rc-lookahead": "3", "x264-params": "sync-lookahead=0"}
_DEFAULTS: dict[str, dict[str, str]] = {
    "libx264": _X264,
    "libx264rgb": _X264,
    "libx265": {"preset": "veryfast", "x265-params": "rc-lookahead=5:frame-threads=2"},
    "libsvtav1": {"preset": "8"},
    # Constant quality needs the rate bound switched off; rows in threads keep it bearable.
    "libvpx-vp9": {"b": "0", "row-mt": "1", "cpu-used": "4"},
    # Quality 2, in the library's unit of lambda (118 to one).
    "mjpeg": {"flags": "+qscale", "global_quality": str(2 * 118), "qmin": "1"},
    "ffv1": {"level": "3", "slicecrc": "1", "g": "1"},
}
_LIVE = {
    "libx264": {"tune": "zerolatency"},
    "libx264rgb": {"tune": "zerolatency"},
    "libx265": {"tune": "zerolatency"},
    "libvpx-vp9": {"deadline": "realtime", "lag-in-frames": "0"},
}
# Encoders with threads of their own, past those of the codec's context: how they are told how many.
_OWN_THREADS = {
    "libx265": ("x265-params", "pools={0}"),
    "libsvtav1": ("svtav1-params", "lp={0}"),
}
# Pixel formats that differ from another in name only, the range being told apart from them.
_PLAIN = {
    "yuvj420p": "yuv420p",
    "yuvj422p": "yuv422p",
    "yuvj444p": "yuv444p",
    "yuvj440p": "yuv440p",
}
# Lossless repackings that the encoder makes of a frame on its way in.
_REPACK = {
    "libx264rgb": {"gbrp": "rgb24"},
    "libx265": {"rgb24": "gbrp", "bgr24": "gbrp"},
    "ffv1": {
        **dict.fromkeys(("rgb24", "bgr24", "gbrp", "rgb0", "0rgb", "0bgr"), "bgr0"),
        **dict.fromkeys(("rgba", "argb", "abgr", "gbrap"), "bgra"),
    },
}


@dataclass(frozen=True)
class EncoderChoice:
    """What the user asks of the encoder; None leaves it to the source.

    ``crf`` is in the encoder's own scale; ``options`` go to the encoder as they are. ``live`` asks for
    every frame at once. ``threads`` are those that it may use, 0 for as many as there are cores.
    """

    codec: str | None = None
    crf: float | None = None
    preset: str | None = None
    pix_fmt: str | None = None
    options: dict[str, str] = field(default_factory=dict)
    live: bool = False
    threads: int = 0


@dataclass(frozen=True)
class EncoderSettings:
    """An encoder by name, the pixel format that it is fed, and its options."""

    codec: str
    pix_fmt: str
    options: dict[str, str]


def settle(choice: EncoderChoice, info: StreamInfo, container: ContainerKind) -> EncoderSettings:
    """Decide on the encoder for ``info`` in a container.

    Raises OutputError where the chosen encoder, or none, suits the container or the pixel format.
    """
    check_names(choice)
    source_format = choice.pix_fmt or info.pix_fmt
    if choice.codec is not None:
        codec = _encoder(choice.codec)
        pix_fmt = _pixel_format(codec, source_format)
        if not container.takes_codec(codec.name, pix_fmt or source_format):
            raise OutputError(f"{container.shown} does not take {codec.canonical_name} video")
        if pix_fmt is None:
            raise OutputError(
                f"{choice.codec} does not take {source_format}; choose one of its formats with"
                f" --pix-fmt: {', '.join(_format_names(codec)[:12])}"
            )
    else:
        # Y4M is what recordings flow through, not what they are kept in.
        is_flow = info.container == "yuv4mpegpipe"
        codec, pix_fmt = _closest("" if is_flow else info.codec, source_format, container)
    return EncoderSettings(codec.name, pix_fmt, _options(codec.name, choice, info.hdr, container))


def check_names(choice: EncoderChoice) -> None:
    """Raise UsageError for an encoder, a pixel format or a preset that does not exist.

    Also for a quality or a preset that no encoder takes which a source may lead to.
    """
    if choice.codec is not None:
        _encoder(choice.codec)
    refusals: list[UsageError] = []
    names = encoders_for(choice)
    for name in names:
        try:
            _quality(name, choice.crf)
            _check_preset(name, choice.preset)
        except UsageError as error:
            refusals.append(error)
    if len(refusals) == len(names):
        raise refusals[0]
    if choice.pix_fmt is not None:
        try:
            av.VideoFormat(choice.pix_fmt)
        except ValueError as error:
            raise UsageError(f"--pix-fmt {choice.pix_fmt}: no such pixel format") from error


def encoders_for(choice: EncoderChoice) -> tuple[str, ...]:
    """Return the encoders that a source may lead to, by name: the one that was chosen, if one was."""
    if choice.codec is not None:
        return (choice.codec,)
    names = dict.fromkeys((*_FALLBACKS, *_FAMILY.values()))
    return tuple(name for name in names if name in av.codecs_available)


def _check_preset(codec: str, preset: str | None) -> None:
    if preset is None:
        return
    if not codec.startswith(_WITH_PRESETS):
        raise UsageError(f"--preset {preset}: {codec} has no presets")
    if codec.startswith("libx26") and preset not in _X26_PRESETS:
        raise UsageError(f"--preset {preset}: {codec} has {', '.join(_X26_PRESETS)}")
    if codec == "libsvtav1" and not preset.removeprefix("-").isdecimal():
        raise UsageError(f"--preset {preset}: {codec} has numbers, -1 to 13")


def _encoder(name: str) -> av.Codec:
    try:
        codec = av.Codec(name, "w")
    except (av.codec.codec.UnknownCodecError, RuntimeError) as error:
        raise UsageError(f"--codec {name}: no such encoder") from error
    if codec.type != "video":
        raise UsageError(f"--codec {name}: encodes {codec.type}, not video")
    return codec


def _closest(codec_name: str, pix_fmt: str, container: ContainerKind) -> tuple[av.Codec, str]:
    first = _FAMILY.get(codec_name, "libx264")
    then = ("ffv1", "png") if codec_name in _LOSSLESS and container.name in _ARCHIVES else ()
    for name in dict.fromkeys((first, *then, *_FALLBACKS)):
        try:
            codec = av.Codec(name, "w")
        except av.codec.codec.UnknownCodecError:
            continue
        suited = _pixel_format(codec, pix_fmt)
        if suited is not None and container.takes_codec(name, suited):
            return codec, suited
    raise OutputError(
        f"no encoder takes {pix_fmt} video for {container.shown}: write .mkv or .mp4, or choose another"
        " --pix-fmt or --codec"
    )


def _format_names(codec: av.Codec) -> list[str]:
    return [f.name for f in codec.video_formats or ()]


def _pixel_format(codec: av.Codec, pix_fmt: str) -> str | None:
    """Return the format to feed the encoder so that it gets ``pix_fmt`` without loss, or None."""
    names = _format_names(codec)
    if not names:
        return pix_fmt
    for name in (_PLAIN.get(pix_fmt, pix_fmt), pix_fmt, _REPACK.get(codec.name, {}).get(pix_fmt)):
        if name in names:
            return name
    return None


def _options(
    codec: str, choice: EncoderChoice, hdr: HdrMetadata, container: ContainerKind
) -> dict[str, str]:
    options = dict(_DEFAULTS.get(codec, {}))
    if choice.preset is not None:
        _check_preset(codec, choice.preset)
        if codec.startswith("libx26"):
            options = {}
        options["preset"] = choice.preset
    options |= _quality(codec, choice.crf)
    if not container.reorders and codec.startswith("libx26"):
        options["bf"] = "0"
    if choice.live:
        options |= _LIVE.get(codec, {})
    if codec in ("libx264", "libx265"):
        _join(options, _static_metadata(codec, hdr))
    if codec == "libx265":
        # Its own chatter goes to the terminal past every log setting of the library.
        _join(options, {"x265-params": "log-level=none"})
    if choice.threads and codec in _OWN_THREADS:
        option, text = _OWN_THREADS[codec]
        _join(options, {option: text.format(choice.threads)})
    _join(options, choice.options)
    return options


def _quality(codec: str, crf: float | None) -> dict[str, str]:
    """Return the option for constant quality; UsageError for one that the encoder does not have."""
    if codec not in _QUALITY:
        if crf is not None:
            raise UsageError(f"--crf: {codec} has no constant quality")
        return {}
    option, value = _QUALITY[codec]
    if crf is not None and not 0 <= crf <= _CRF_LIMIT[codec]:
        raise UsageError(f"--crf {crf:g}: {codec} takes 0 to {_CRF_LIMIT[codec]}")
    return {option: f"{value if crf is None else crf:g}"}


def _join(options: dict[str, str], more: dict[str, str]) -> None:
    """Add options; lists of parameters for the encoder behind the encoder grow instead of being replaced."""
    for key, text in more.items():
        grows = key.endswith("-params") and key in options
        options[key] = f"{options[key]}:{text}" if grows else text


def _static_metadata(codec: str, hdr: HdrMetadata) -> dict[str, str]:
    parts = []
    if hdr.mastering:
        name = "mastering-display" if codec == "libx264" else "master-display"
        parts.append(f"{name}={hdr.mastering}")
    if hdr.light_level:
        parts.append(f"{'cll' if codec == 'libx264' else 'max-cll'}={hdr.light_level}")
    return {codec.removeprefix("lib") + "-params": ":".join(parts)} if parts else {}
