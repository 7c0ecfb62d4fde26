"""What decoders say is heard, however much it is, wherever files cannot be written, and only meanwhile."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
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


def test_pictures_are_read_where_nothing_can_be_written(nowhere: None) -> None:
    image = np.random.default_rng(4).integers(0, 256, (160, 240, 3), np.uint8)
    data = cv2.imencode(".jpg", image)[1].tobytes()
    assert decode_image(data).shape == image.shape


def test_damage_is_told_without_a_temporary_directory(monkeypatch: pytest.MonkeyPatch) -> None:
    if not hasattr(os, "memfd_create"):
        pytest.skip("no files in memory here")
    monkeypatch.setattr(tempfile, "tempdir", "/nowhere")
    image = np.random.default_rng(4).integers(0, 256, (160, 240, 3), np.uint8)
    data = bytearray(cv2.imencode(".jpg", image)[1].tobytes())
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


def test_a_program_that_was_started_meanwhile_may_go_on_writing() -> None:
    late = "import sys, time; time.sleep(0.3); print('late', file=sys.stderr, flush=True)"
    with decoder_words() as words:
        program = subprocess.Popen([sys.executable, "-c", late])
        os.write(STDERR, b"meanwhile\n")
    assert words == ["meanwhile"]
    assert program.wait() == 0


def test_an_interrupt_leaves_standard_error_as_it_was(capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(KeyboardInterrupt), decoder_words():
        raise KeyboardInterrupt
    os.write(STDERR, b"after\n")
    assert capfd.readouterr().err == "after\n"


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no forks here")
def test_a_child_forked_while_a_thread_listens_can_listen_too() -> None:
    code = (
        "import os, signal, sys, threading\n"
        "from endocal.files.decoder_words import decoder_words\n"
        "inside, done = threading.Event(), threading.Event()\n"
        "def listen():\n"
        "    with decoder_words():\n"
        "        inside.set(); done.wait()\n"
        "thread = threading.Thread(target=listen); thread.start(); inside.wait()\n"
        "child = os.fork()\n"
        "if not child:\n"
        "    signal.alarm(10)\n"
        "    with decoder_words():\n"
        "        pass\n"
        "    os._exit(0)\n"
        "_, status = os.waitpid(child, 0)\n"
        "done.set(); thread.join(); sys.exit(os.waitstatus_to_exitcode(status))\n"
    )
    assert subprocess.run([sys.executable, "-W", "ignore", "-c", code], check=False).returncode == 0
