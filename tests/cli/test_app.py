"""Every way of going wrong ends in its exit code and one line."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from endocal.cli import app
from endocal.errors import DeviceError, EndocalError, InputError, UsageError

Runner = Callable[..., Any]


@pytest.fixture
def failing(monkeypatch: pytest.MonkeyPatch) -> Callable[[BaseException], None]:
    """Add a command ``fail`` that raises."""

    def add(error: BaseException) -> None:
        def command() -> None:
            raise error

        module = ModuleType("endocal.cli.fail")
        module.command = command  # type: ignore[attr-defined]
        monkeypatch.setitem(sys.modules, "endocal.cli.fail", module)
        monkeypatch.setitem(app.COMMANDS, "Test", ("fail",))

    return add


@pytest.mark.parametrize(
    ("error", "code", "line"),
    [
        (EndocalError("it broke"), 1, "endocal: it broke"),
        (InputError("a.mp4: broke\nat line 2"), 1, "endocal: a.mp4: broke at line 2"),
        (DeviceError("no device"), 1, "endocal: no device"),
        (UsageError("not both"), 2, "endocal: not both"),
        (KeyboardInterrupt(), 130, "endocal: interrupted"),
        (MemoryError(), 1, "endocal: out of memory"),
        (PermissionError(13, "Permission denied", "a.mp4"), 1, "endocal: a.mp4: Permission denied"),
        (OSError(28, "No space left on device"), 1, "endocal: No space left on device"),
        (BrokenPipeError(32, "Broken pipe"), 1, "endocal: Broken pipe"),
        (
            ZeroDivisionError("division by zero"),
            1,
            "endocal: internal error: ZeroDivisionError: division by zero"
            " (ENDOCAL_DEBUG=1 shows where; please report it)",
        ),
    ],
)
def test_errors_become_exit_codes(
    endocal: Runner, failing: Any, error: BaseException, code: int, line: str
) -> None:
    failing(error)
    result = endocal("fail")
    assert (result.code, result.out, result.err) == (code, "", line + "\n")


def test_debugging_shows_where(
    endocal: Runner, failing: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ENDOCAL_DEBUG", "1")
    failing(InputError("it broke"))
    result = endocal("fail")
    assert result.code == 1
    assert "Traceback" in result.err
    assert result.err.endswith("endocal: it broke\n")


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (["--nonsense"], "No such option"),
        (["nonsense"], "No such command"),
        (["show"], "Missing argument"),
        (["show", "--nonsense"], "No such option"),
        (["show", "a", "b"], "unexpected extra argument"),
    ],
)
def test_wrong_usage_is_exit_2(endocal: Runner, args: list[str], words: str) -> None:
    assert words in endocal(*args).fails(2)


def test_no_command_shows_the_help(endocal: Runner) -> None:
    result = endocal()
    assert (result.code, result.out) == (2, "")
    assert "Usage" in result.err


@pytest.mark.parametrize(
    ("line", "completions"),
    [("endocal sh", {"show"}), ("endocal show --js", {"--json"})],
)
def test_the_shell_completes(endocal_process: Runner, line: str, completions: set[str]) -> None:
    words = line.split()
    env = {
        "_ENDOCAL_COMPLETE": "complete_bash",
        "COMP_WORDS": line,
        "COMP_CWORD": str(len(words) - 1),
    }
    result = endocal_process(env=env)
    assert result.code == 0
    assert set(result.out.split()) == completions


@pytest.mark.parametrize("option", ["-h", "--help"])
def test_help_is_exit_0_on_stdout(endocal: Runner, option: str) -> None:
    for args in ([option], ["show", option]):
        result = endocal(*args)
        assert result.code == 0
        assert "Usage" in result.out
        assert result.err == ""


def test_version(endocal: Runner) -> None:
    from endocal import __version__

    assert endocal("--version").out == f"endocal {__version__}\n"


def test_a_reader_that_leaves_ends_it_quietly(tmp_path: Path) -> None:
    # `endocal show … | true`: the reader is gone before the first byte.
    read, write = os.pipe()
    os.close(read)
    path = tmp_path / "cal.toml"
    path.write_text(
        'schema = "endocal.calibration/1"\n[model]\n'
        'type = "division"\nlambda = 0\ncenter = [9, 9]\nsize = [20, 20]\n'
    )
    for args in (["show", path], ["show", path, "--json"], ["show", "--help"], ["--help"]):
        done = subprocess.run(
            [sys.executable, "-m", "endocal", *args],
            stdout=write,
            stderr=subprocess.PIPE,
            check=False,
        )
        assert (done.returncode, done.stderr) == (0, b"")
    os.close(write)


KILL_ITSELF = """
import os, sys, time, types
from endocal.cli import app
from endocal.files import atomic_output

def command(path: str, number: int) -> None:
    with atomic_output(path) as temporary:
        temporary.write_text("half")
        os.kill(os.getpid(), number)
        time.sleep(60)

sys.modules["endocal.cli.work"] = module = types.ModuleType("work")
module.command = command
app.COMMANDS["Test"] = ("work",)
app.main()
"""


@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129)]
)
def test_a_signal_ends_it_with_its_code_and_leaves_nothing(
    tmp_path: Path, number: signal.Signals, code: int
) -> None:
    done = subprocess.run(
        [sys.executable, "-c", KILL_ITSELF, "work", str(tmp_path / "out.mp4"), str(int(number))],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout) == (code, "")
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(os.name != "posix", reason="closes descriptors as a POSIX shell does")
@pytest.mark.parametrize(
    ("closed", "args", "code", "words"),
    [
        (0, ("show", "-"), 1, "stdin"),
        (
            1,
            ("synth", "board", "-o", "board.png"),
            1,
            "endocal: standard output: is closed: send it",
        ),
        (2, ("synth", "board", "-o", "board.png"), 0, ""),
    ],
)
def test_a_standard_stream_that_is_closed(
    tmp_path: Path, closed: int, args: tuple[str, ...], code: int, words: str
) -> None:
    """No traceback, no internal error, and nothing printed into a file that got the stream's number."""
    done = subprocess.run(
        [sys.executable, "-m", "endocal", *args, *(("--json",) if closed == 1 else ())],
        cwd=tmp_path,
        preexec_fn=lambda: os.close(closed),
        capture_output=True,
        check=False,
    )
    assert done.returncode == code
    assert b"internal error" not in done.stderr
    assert words.encode() in done.stderr
    for picture in tmp_path.glob("*.png"):
        assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
@pytest.mark.parametrize("unbuffered", ["", "1"])
@pytest.mark.parametrize("args", [["--version"], ["--help"], ["show", "cal.toml"]])
def test_a_standard_output_that_is_full(tmp_path: Path, args: list[str], unbuffered: str) -> None:
    """One line that says where and what to do, and the exit code of a failure, not one of Python's own."""
    (tmp_path / "cal.toml").write_text(
        'schema = "endocal.calibration/1"\n[model]\n'
        'type = "division"\nlambda = 0\ncenter = [9, 9]\nsize = [20, 20]\n'
    )
    with open("/dev/full", "wb") as full:
        done = subprocess.run(
            [sys.executable, "-m", "endocal", *args],
            cwd=tmp_path,
            env={**os.environ, "PYTHONUNBUFFERED": unbuffered},
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert (done.returncode, done.stderr) == (
        1,
        "endocal: standard output: No space left on device: make room, or send it elsewhere\n",
    )
