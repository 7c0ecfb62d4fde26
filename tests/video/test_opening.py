"""Encoders that refuse: what the user asked of them is wrong usage, the rest is a failure."""

from __future__ import annotations

from fractions import Fraction

import av
import pytest

from endocal.errors import OutputError, UsageError
from endocal.video.encoder import EncoderChoice
from endocal.video.opening import open_encoder


def attempt(
    codec: str = "libx264",
    size: tuple[int, int] = (64, 48),
    asked: bool = False,
    preset: str | None = None,
    **options: str,
) -> None:
    context = av.CodecContext.create(codec, "w")
    assert isinstance(context, av.VideoCodecContext)
    context.width, context.height = size
    context.pix_fmt, context.time_base = "yuv420p", Fraction(1, 25)
    context.options = {**options, **({"preset": preset} if preset else {})}
    if codec == "libx265":
        context.options = {"x265-params": "log-level=none", **options}
    open_encoder(context, EncoderChoice(codec, None, preset, None, options), "out.mp4", asked)


@pytest.mark.parametrize(
    ("codec", "options", "words"),
    [
        ("libx264", {"profile": "nosuch"}, "libx264 has baseline"),
        ("libx264", {"tune": "film,nosuch"}, "libx264 has film"),
        ("libx264", {"b": "abc"}, "option b to value abc"),
        ("libx264", {"nosuch": "1"}, "has no such option"),
        ("libx264", {"x264-params": "nosuch=1"}, "Error parsing option 'nosuch = 1'"),
        ("libx264", {"x264-params": "keyint=abc"}, "'keyint = abc'"),
        ("libx265", {"x265-params": "log-level=none:nosuch=1"}, "Unknown option: nosuch"),
        ("libx265", {"x265-params": "log-level=none:keyint=abc"}, "Invalid value for keyint"),
    ],
)
def test_an_option_that_it_does_not_take_is_wrong_usage(
    capfd: pytest.CaptureFixture[str], codec: str, options: dict[str, str], words: str
) -> None:
    with pytest.raises(UsageError, match=words):
        attempt(codec, **options)
    assert capfd.readouterr().err == "", "nothing is said past the message"


def test_a_preset_that_it_does_not_take_is_wrong_usage() -> None:
    with pytest.raises(UsageError, match="preset to value nosuch"):
        attempt("libsvtav1", preset="nosuch")


@pytest.mark.parametrize("codec", ["libx264", "libx265"])
def test_a_size_between_two_chroma_samples(codec: str) -> None:
    """The user's own is wrong usage; the recording's own is a failure, with the way out in both."""
    for asked, kind in ((True, UsageError), (False, OutputError)):
        with pytest.raises(kind, match=r"does not take 63x47 .*--size 62x46"):
            attempt(codec, (63, 47), asked)
    attempt("ffv1", (63, 47))


def test_an_encoder_without_its_hardware_is_a_failure() -> None:
    with pytest.raises(OutputError, match=r"out\.mp4: h264_v4l2m2m refuses frames of 64x48"):
        attempt("h264_v4l2m2m")
