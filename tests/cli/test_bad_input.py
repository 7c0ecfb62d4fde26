"""Bad input to the main commands: one clear line, the right exit code, and no output file."""

from __future__ import annotations

import struct
import wave
from collections.abc import Callable
from pathlib import Path
from typing import Any

import av
import cv2
import numpy as np
import pytest

Runner = Callable[..., Any]

SIZE = (96, 64)
CALIBRATION = """
schema = "endocal.calibration/1"
[model]
type = "division"
lambda = -2e-5
center = [48, 32]
size = [96, 64]
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a sound clip, picture and calibration to spoil."""
    (tmp_path / "cal.toml").write_text(CALIBRATION)
    ramp = np.add.outer(np.arange(SIZE[1]), np.arange(SIZE[0])).astype(np.uint8)
    cv2.imwrite(str(tmp_path / "picture.png"), ramp)
    with av.open(str(tmp_path / "clip.mp4"), "w") as container:
        stream = container.add_stream("libx264", rate=25)
        stream.width, stream.height, stream.pix_fmt = *SIZE, "yuv420p"
        for i in range(3):
            frame = av.VideoFrame.from_ndarray(ramp + np.uint8(i), format="gray")
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    return tmp_path


def refused(result: Any, folder: Path, before: set[Path], words: str, code: int = 1) -> None:
    assert words in result.fails(code)
    assert set(folder.rglob("*")) == before


def correct(endocal: Runner, folder: Path, words: str, *options: str, **names: str) -> None:
    """Run ``correct`` on the folder with some names changed and expect a refusal in these words."""
    use = {"input": "clip.mp4", "output": "out.mp4", "config": "cal.toml", **names}
    before = set(folder.rglob("*"))
    result = endocal(
        "correct",
        folder / use["input"],
        "-o",
        folder / use["output"],
        "-c",
        folder / use["config"],
        *options,
    )
    refused(result, folder, before, words)


def test_the_sound_ones_work(endocal: Runner, folder: Path) -> None:
    for source, out in (("clip.mp4", "out.mp4"), ("picture.png", "out.png")):
        result = endocal(
            "correct",
            folder / source,
            "-o",
            folder / out,
            "-c",
            folder / "cal.toml",
            "--device",
            "numpy",
        )
        assert result.code == 0, result.err
        assert (folder / out).stat().st_size > 0


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (CALIBRATION, "", "cal.toml: is empty"),
        (CALIBRATION, "a = 1", "cal.toml: not an endocal file"),
        (CALIBRATION, "hello there", "cal.toml: not a TOML document"),
        ("-2e-5", "nan", "cal.toml: [model] lambda is nan"),
        ("-2e-5", "-2e-3", "cal.toml: [model] lambda -0.002 folds the picture"),
        ("[48, 32]", "[480, 32]", "cal.toml: [model] the centre (480, 32) lies far outside"),
        ("[96, 64]", "[96, 96]", "another shape"),
    ],
)
@pytest.mark.parametrize("source", ["clip.mp4", "picture.png"])
def test_a_calibration_that_is_none(
    endocal: Runner, folder: Path, source: str, old: str, new: str, words: str
) -> None:
    (folder / "cal.toml").write_text(CALIBRATION.replace(old, new))
    correct(endocal, folder, words, input=source, output="out" + Path(source).suffix)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (None, "no such file"),
        (b"", "empty"),
        (b"this is a text and no film" * 99, "bad.mp4"),
    ],
)
def test_an_input_that_is_no_video(
    endocal: Runner, folder: Path, data: bytes | None, words: str
) -> None:
    if data is not None:
        (folder / "bad.mp4").write_bytes(data)
    correct(endocal, folder, words, input="bad.mp4")


@pytest.mark.parametrize(
    ("share", "words"), [(0.1, "is truncated"), (0.9, "is truncated"), (0.0, "empty")]
)
def test_a_picture_that_is_cut_short(
    endocal: Runner, folder: Path, share: float, words: str
) -> None:
    whole = (folder / "picture.png").read_bytes()
    (folder / "bad.png").write_bytes(whole[: int(len(whole) * share)])
    correct(endocal, folder, words, input="bad.png", output="out.png")


def test_the_decoder_adds_no_lines_of_its_own(endocal_process: Runner, folder: Path) -> None:
    # A TIFF of 5 bits a pixel: OpenCV would log three lines about it.
    whole = bytearray(cv2.imencode(".tif", np.zeros((40, 60), np.uint8))[1].tobytes())
    whole[whole.index(struct.pack("<HHI", 258, 3, 1)) + 8] = 5
    (folder / "bad.tif").write_bytes(whole)
    before = set(folder.rglob("*"))
    names = [folder / "bad.tif", "-o", folder / "out.png", "-c", folder / "cal.toml"]
    refused(endocal_process("correct", *names), folder, before, "bad.tif: cannot be decoded")


def test_a_picture_of_one_pixel(endocal: Runner, folder: Path) -> None:
    cv2.imwrite(str(folder / "bad.png"), np.zeros((1, 1), np.uint8))
    correct(endocal, folder, "1x1 px is too small", input="bad.png", output="out.png")


def test_a_video_without_video(endocal: Runner, folder: Path) -> None:
    with wave.open(str(folder / "sound.wav"), "wb") as sound:
        sound.setnchannels(1)
        sound.setsampwidth(2)
        sound.setframerate(8000)
        sound.writeframes(bytes(16000))
    correct(endocal, folder, "no video stream", input="sound.wav")


@pytest.mark.parametrize("source", ["clip.mp4", "picture.png"])
def test_an_output_that_exists(endocal: Runner, folder: Path, source: str) -> None:
    out = "out" + Path(source).suffix
    (folder / out).write_text("precious")
    correct(endocal, folder, f"{out}: exists already", input=source, output=out)
    assert (folder / out).read_text() == "precious"


@pytest.mark.parametrize("source", ["clip.mp4", "picture.png"])
def test_an_output_that_is_the_input(endocal: Runner, folder: Path, source: str) -> None:
    data = (folder / source).read_bytes()
    correct(endocal, folder, "is also an input", "--overwrite", input=source, output=source)
    assert (folder / source).read_bytes() == data


@pytest.mark.parametrize("source", ["clip.mp4", "picture.png"])
def test_an_output_directory_that_is_not_there(endocal: Runner, folder: Path, source: str) -> None:
    correct(endocal, folder, "does not exist", input=source, output=f"no/out{Path(source).suffix}")


@pytest.mark.parametrize("source", ["clip.mp4", "picture.png"])
def test_no_opencl_device(
    endocal: Runner, folder: Path, monkeypatch: pytest.MonkeyPatch, source: str
) -> None:
    cl = pytest.importorskip("pyopencl")

    def none() -> None:
        raise cl.LogicError("clGetPlatformIDs failed: PLATFORM_NOT_FOUND_KHR")

    monkeypatch.setattr(cl, "get_platforms", none)
    out = "out" + Path(source).suffix
    correct(endocal, folder, "no OpenCL device was found", input=source, output=out)


def test_a_device_that_is_not_there_is_not_replaced(endocal: Runner, folder: Path) -> None:
    before = set(folder.rglob("*"))
    names = [folder / "clip.mp4", "-o", folder / "out.mp4", "-c", folder / "cal.toml"]
    result = endocal("correct", *names, "--device", "no such thing")
    refused(result, folder, before, "no OpenCL device", code=2)


@pytest.mark.parametrize(
    "options",
    [
        ["--size", "12"],
        ["--size", "0x5"],
        ["--view", "sideways"],
        ["--interpolation", "magic"],
        ["--deinterlace", "maybe"],
        ["--scale", "wide"],
        ["--codec-option", "novalue"],
        ["--nonsense"],
    ],
)
def test_wrong_usage(endocal: Runner, folder: Path, options: list[str]) -> None:
    before = set(folder.rglob("*"))
    names = [folder / "clip.mp4", "-o", folder / "out.mp4", "-c", folder / "cal.toml"]
    result = endocal("correct", *names, *options)
    refused(result, folder, before, "", code=2)


def test_an_output_and_a_calibration_are_needed(endocal: Runner, folder: Path) -> None:
    assert "--output" in endocal("correct", folder / "clip.mp4", "-c", "cal.toml").fails(2)
    assert "--config" in endocal("correct", folder / "clip.mp4", "-o", "out.mp4").fails(2)
