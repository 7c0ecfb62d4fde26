"""What a video stream is: all that must come out of a correction as it went in."""

from __future__ import annotations

import re
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

import av
import av.container
import av.logging
from av.sidedata.sidedata import Type as SideDataType

from .messages import heard

CHROMA_LOCATIONS = ("left", "center", "topleft", "top", "bottomleft", "bottom")

# Side data of frames that travels with no frame made anew, in words.
_EXTRAS = {
    SideDataType.A53_CC: "the text of closed captions",
    SideDataType.STEREO3D: "the mark of two eyes in a frame",
    SideDataType.SPHERICAL: "the mark of a spherical picture",
    SideDataType.DYNAMIC_HDR_PLUS: "dynamic HDR10+ metadata",
    SideDataType.DOVI_METADATA: "Dolby Vision metadata",
}

# Chromaticities are in 1/50000 and luminances in 1/10000 cd/m^2 in the encoders' notation.
_CHROMATICITY_UNIT = 50000
_LUMINANCE_UNIT = 10000


@dataclass(frozen=True)
class Colour:
    """The colour description, as the numbers of ITU-T H.273 (2: unspecified).

    ``full_range`` is None where the stream does not say; ``chroma_location`` is one of CHROMA_LOCATIONS, or
    None where it does not say.
    """

    full_range: bool | None
    matrix: int
    primaries: int
    transfer: int
    chroma_location: str | None


@dataclass(frozen=True)
class HdrMetadata:
    """Mastering display and content light level, in the encoders' text form; None where absent."""

    mastering: str | None = None
    light_level: str | None = None


@dataclass(frozen=True)
class StreamInfo:
    """One video stream, as its first decoded frame and its container describe it.

    ``size`` is (width, height) in samples and ``pix_fmt`` the format in which frames are handed out;
    ``sample_aspect`` is a pixel's width over its height (None: not said); ``rate`` in frames per second;
    ``start`` and ``duration`` in seconds, and ``frames`` the number of frames that the container declares:
    None where it does not say. ``display_matrix`` is the container's 3x3 matrix in row order (16.16 and 2.30
    fixed point), or None. ``extras`` names what the first frame carries beside its pixels that no output
    can be given.
    """

    index: int
    codec: str
    container: str
    size: tuple[int, int]
    pix_fmt: str
    bits: int
    sample_aspect: Fraction | None
    rate: Fraction
    time_base: Fraction
    start: float | None
    duration: float | None
    frames: int | None
    colour: Colour
    hdr: HdrMetadata
    display_matrix: tuple[int, ...] | None
    interlaced: bool
    extras: tuple[str, ...] = ()

    @property
    def full_range(self) -> bool:
        """Whether the samples use the full range; RGB and the yuvj formats always do."""
        if self.pix_fmt.startswith(("yuvj", "rgb", "bgr", "gbr", "argb", "abgr")):
            return True
        return bool(self.colour.full_range)


def describe(
    container: av.container.InputContainer,
    stream: av.VideoStream,
    frame: av.VideoFrame,
    described: Mapping[int, str],
) -> StreamInfo:
    """Collect what the container and the first decoded frame say about a video stream.

    ``described`` are the container's ``descriptions``.
    """
    aspect = stream.sample_aspect_ratio or stream.codec_context.sample_aspect_ratio
    time_base = frame.time_base or stream.time_base or Fraction(1, av.time_base)
    duration = float(stream.duration * time_base) if stream.duration else None
    if duration is None and container.duration:
        duration = container.duration / av.time_base
    return StreamInfo(
        index=stream.index,
        codec=stream.codec_context.codec.canonical_name,
        container=container.format.name,
        size=(frame.width, frame.height),
        pix_fmt=frame.format.name,
        bits=max(c.bits for c in frame.format.components),
        sample_aspect=aspect or None,
        rate=stream.average_rate or stream.guessed_rate or stream.base_rate or Fraction(25),
        time_base=time_base,
        start=frame.time,
        duration=duration,
        frames=stream.frames or None,
        colour=Colour(
            full_range={1: False, 2: True}.get(int(frame.color_range)),
            matrix=int(frame.colorspace),
            primaries=int(frame.color_primaries),
            transfer=int(frame.color_trc),
            chroma_location=_chroma_location(described.get(stream.index, "")),
        ),
        hdr=_hdr(frame),
        display_matrix=_display_matrix(frame),
        interlaced=bool(frame.interlaced_frame),
        extras=(
            *(name for kind, name in _EXTRAS.items() if _side_data(frame, kind) is not None),
            *(("transparency",) if _is_made_opaque(stream, frame) else ()),
        ),
    )


def _is_made_opaque(stream: av.VideoStream, frame: av.VideoFrame) -> bool:
    """Tell whether a frame, in the format to work in, has lost the transparency that the stream has."""
    native = stream.codec_context.format
    before, after = (
        fmt is not None and any(c.is_alpha for c in fmt.components)
        for fmt in (native, frame.format)
    )
    return before and not after


def descriptions(container: av.container.InputContainer) -> dict[int, str]:
    """Return the library's one-line description of each stream: the only way to some facts."""
    # The chroma location is named in the details alone.
    with heard(av.logging.INFO, in_detail=True):
        text: str = container.dumps_format()  # type: ignore[attr-defined]
    return {
        int(i): line for i, line in re.findall(r"^ *Stream #0:(\d+)\b(.*)$", text, re.MULTILINE)
    }


def fourcc(description: str) -> str | None:
    """Return the container's four-letter name of a stream's format, as in ``none (tmcd / 0x64636D74)``."""
    match = re.search(r"\((\w{4}) / 0x[0-9A-F]{8}\)", description)
    return match.group(1) if match else None


def _chroma_location(description: str) -> str | None:
    # Among the words in brackets after the pixel format, as in ``yuv420p(tv, bt709, progressive, left)``.
    for words in re.findall(r"\(([^()]*)\)", description):
        for word in words.split(", "):
            if word in CHROMA_LOCATIONS:
                return str(word)
    return None


def _side_data(frame: av.VideoFrame, kind: SideDataType) -> bytes | None:
    try:
        return bytes(frame.side_data[kind])  # type: ignore[literal-required]
    except (KeyError, ValueError):
        # Absent; or a frame with data of a kind that PyAV does not know yet gives none at all.
        return None


def _display_matrix(frame: av.VideoFrame) -> tuple[int, ...] | None:
    data = _side_data(frame, SideDataType.DISPLAYMATRIX)
    return struct.unpack("=9i", data[:36]) if data else None


def _hdr(frame: av.VideoFrame) -> HdrMetadata:
    return HdrMetadata(_mastering(frame), _light_level(frame))


def _mastering(frame: av.VideoFrame) -> str | None:
    """SMPTE ST 2086 data as ``G(x,y)B(x,y)R(x,y)WP(x,y)L(max,min)``."""
    data = _side_data(frame, SideDataType.MASTERING_DISPLAY_METADATA)
    if data is None:
        return None
    # AVMasteringDisplayMetadata: ten rationals (R, G, B and white x, y; min, max luminance), two flags.
    numbers = struct.unpack("=22i", data[:88])
    values = [
        Fraction(numbers[i], numbers[i + 1]) if numbers[i + 1] else Fraction(0)
        for i in range(0, 20, 2)
    ]
    has_primaries, has_luminance = numbers[20], numbers[21]
    if not (has_primaries and has_luminance):
        return None
    r, g, b, white = (
        tuple(round(v * _CHROMATICITY_UNIT) for v in values[i : i + 2]) for i in (0, 2, 4, 6)
    )
    low, high = (round(v * _LUMINANCE_UNIT) for v in values[8:10])
    return "G({},{})B({},{})R({},{})WP({},{})L({},{})".format(*g, *b, *r, *white, high, low)


def _light_level(frame: av.VideoFrame) -> str | None:
    """CTA-861.3 maximum content and frame-average light level, cd/m^2, as ``content,average``."""
    data = _side_data(frame, SideDataType.CONTENT_LIGHT_LEVEL)
    return "{},{}".format(*struct.unpack("=2I", data[:8])) if data else None
