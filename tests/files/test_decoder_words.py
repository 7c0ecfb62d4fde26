"""What decoders say is heard, however much it is, wherever files cannot be written, and only meanwhile."""

from __future__ import annotations

import os
import resource
import tempfile
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest

from endocal.errors import InputError
from endocal.files import decode_image
from endocal.files.decoder_words import decoder_words

STDERR = 2


@pytest.fixture(params=["no temporary directory", "no room for files"])
def nowhere(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A process that cannot write temporary files."""
    if request.param == "no temporary directory":
        monkeypatch.setattr(tempfile, "tempdir", "/nowhere")
        yield
        return
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_pictures_are_read_and_damage_is_told_without_temporary_files(nowhere: None) -> None:
    image = np.random.default_rng(4).integers(0, 256, (160, 240, 3), np.uint8)
    data = bytearray(cv2.imencode(".jpg", image)[1].tobytes())
    assert decode_image(bytes(data)).shape == image.shape
    middle = len(data) // 2
    data[middle : middle + 300] = bytes(300)
    with pytest.raises(InputError, match="is damaged in the middle"):
        decode_image(bytes(data))


def test_many_words_are_all_heard() -> None:
    said = [f"word {i} of a decoder that has much to say" for i in range(20_000)]
    with decoder_words() as words:
        for line in said:
            os.write(STDERR, f"{line}\n".encode())
    assert words == said


def test_words_before_and_after_go_where_they_went(
    capfd: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    os.write(STDERR, b"before\n")
    descriptors = len(os.listdir("/proc/self/fd")) if Path("/proc/self/fd").is_dir() else 0
    for _ in range(3):
        with decoder_words() as words:
            os.write(STDERR, b"meanwhile")
        assert words == ["meanwhile"]
    os.write(STDERR, b"after\n")
    assert capfd.readouterr().err == "before\nafter\n"
    if descriptors:
        assert len(os.listdir("/proc/self/fd")) == descriptors


def test_a_program_that_still_holds_the_other_end_holds_nothing_up() -> None:
    with decoder_words() as words:
        held = os.dup(STDERR)
        os.write(STDERR, b"meanwhile\n")
    os.close(held)
    assert words == ["meanwhile"]
