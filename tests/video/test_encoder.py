"""The encoder that comes closest to the source, and the options that it gets."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import pytest

from endocal.errors import OutputError, UsageError
from endocal.video.container import ContainerKind
from endocal.video.encoder import EncoderChoice, settle
from endocal.video.stream import Colour, HdrMetadata, StreamInfo

INFO = StreamInfo(
    index=0,
    codec="h264",
    container="mov,mp4,m4a,3gp,3g2,mj2",
    size=(64, 48),
    pix_fmt="yuv420p",
    bits=8,
    sample_aspect=None,
    rate=Fraction(25),
    time_base=Fraction(1, 12800),
    start=0.0,
    duration=1.0,
    frames=25,
    colour=Colour(None, 2, 2, 2, "left"),
    hdr=HdrMetadata(),
    display_matrix=None,
    interlaced=False,
)


@pytest.mark.parametrize(
    ("codec", "pix_fmt", "container", "encoder", "fed"),
    [
        ("h264", "yuv420p", "mp4", "libx264", "yuv420p"),
        ("h264", "yuvj420p", "mp4", "libx264", "yuv420p"),
        ("h264", "yuv422p10le", "mov", "libx264", "yuv422p10le"),
        ("h264", "gbrp", "matroska", "libx264rgb", "rgb24"),
        ("h264", "yuv420p12le", "mp4", "libx265", "yuv420p12le"),
        ("hevc", "yuv420p10le", "mp4", "libx265", "yuv420p10le"),
        ("hevc", "yuv420p", "mpegts", "libx265", "yuv420p"),
        ("mpeg2video", "yuv422p", "mpegts", "libx264", "yuv422p"),
        ("ffv1", "gray16le", "matroska", "ffv1", "gray16le"),
        ("prores", "yuv422p10le", "mov", "prores_ks", "yuv422p10le"),
        ("vp9", "yuv420p", "webm", "libvpx-vp9", "yuv420p"),
        ("h264", "yuv420p", "webm", "libvpx-vp9", "yuv420p"),
        ("rawvideo", "yuv420p", "yuv4mpegpipe", "rawvideo", "yuv420p"),
        ("h264", "yuv420p10le", "yuv4mpegpipe", "rawvideo", "yuv420p10le"),
        ("rawvideo", "yuv420p", "mp4", "libx264", "yuv420p"),
        ("rawvideo", "bgr0", "matroska", "ffv1", "bgr0"),
        ("rawvideo", "rgb24", "matroska", "ffv1", "bgr0"),
        ("rawvideo", "bgr24", "avi", "rawvideo", "bgr24"),
        ("png", "rgb24", "matroska", "ffv1", "bgr0"),
        ("apng", "rgba", "mov", "png", "rgba"),
        *(
            ("rawvideo", pix_fmt, container, "ffv1", pix_fmt)
            for pix_fmt in ("gray10le", "gray16le", "yuv440p", "yuva420p")
            for container in ("matroska", "avi")
        ),
        ("rawvideo", "gray", "matroska", "rawvideo", "gray"),
        ("png", "rgb24", "mov", "png", "rgb24"),
        ("utvideo", "yuv422p", "avi", "ffv1", "yuv422p"),
        ("vp8", "yuv420p", "webm", "libvpx-vp9", "yuv420p"),
        ("h264", "yuv420p", "rawvideo", "rawvideo", "yuv420p"),
    ],
)
def test_the_closest_encoder(
    codec: str, pix_fmt: str, container: str, encoder: str, fed: str
) -> None:
    info = replace(INFO, codec=codec, pix_fmt=pix_fmt)
    settings = settle(EncoderChoice(), info, ContainerKind(container))
    assert (settings.codec, settings.pix_fmt) == (encoder, fed)


def test_what_came_as_y4m_is_encoded() -> None:
    """Y4M carries a recording from one command to the next; kept raw it would fill the disk."""
    flowing = replace(INFO, codec="rawvideo", container="yuv4mpegpipe")
    assert settle(EncoderChoice(), flowing, ContainerKind("matroska")).codec == "libx264"
    assert settle(EncoderChoice(), flowing, ContainerKind("yuv4mpegpipe")).codec == "rawvideo"


def test_the_user_has_the_last_word() -> None:
    choice = EncoderChoice("libx265", 28, "fast", "yuv444p", {"x265-params": "psy-rd=1", "g": "9"})
    settings = settle(choice, INFO, ContainerKind("mp4"))
    assert (settings.codec, settings.pix_fmt) == ("libx265", "yuv444p")
    assert settings.options["crf"] == "28"
    assert settings.options["preset"] == "fast"
    assert settings.options["g"] == "9"
    assert settings.options["x265-params"].endswith("psy-rd=1")


def test_hdr_goes_to_the_encoder_in_its_own_words() -> None:
    mastering = "G(13250,34500)B(7500,3000)R(34000,16000)WP(15635,16450)L(10000000,50)"
    info = replace(INFO, codec="hevc", hdr=HdrMetadata(mastering, "1000,400"))
    parameters = settle(EncoderChoice(), info, ContainerKind("mp4")).options["x265-params"]
    assert f"master-display={mastering}" in parameters.split(":")
    assert "max-cll=1000,400" in parameters.split(":")


@pytest.mark.parametrize(
    ("choice", "words"),
    [
        (EncoderChoice(codec="nosuch"), "no such encoder"),
        (EncoderChoice(pix_fmt="nosuch"), "no such pixel format"),
        (EncoderChoice(crf=99), "libx264 takes 0 to 51"),
        (EncoderChoice(preset="hasty"), "libx264 has ultrafast"),
        (EncoderChoice(codec="ffv1", crf=3), "has no constant quality"),
        (EncoderChoice(codec="ffv1", preset="fast"), "has no presets"),
        (EncoderChoice(codec="aac"), "encodes audio, not video"),
        (EncoderChoice(codec="subrip"), "encodes subtitle, not video"),
    ],
)
def test_wrong_options_are_usage_errors(choice: EncoderChoice, words: str) -> None:
    with pytest.raises(UsageError, match=words):
        settle(choice, INFO, ContainerKind("matroska"))


def test_what_does_not_fit_is_refused() -> None:
    with pytest.raises(OutputError, match="webm does not take h264"):
        settle(EncoderChoice(codec="libx264"), INFO, ContainerKind("webm"))
    with pytest.raises(OutputError, match="does not take yuv422p"):
        settle(EncoderChoice(codec="mpeg4", pix_fmt="yuv422p"), INFO, ContainerKind("mp4"))
    with pytest.raises(OutputError, match="no encoder takes gray16le video for webm"):
        settle(EncoderChoice(), replace(INFO, pix_fmt="gray16le"), ContainerKind("webm"))
