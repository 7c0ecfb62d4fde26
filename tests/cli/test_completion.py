"""The shell completes commands, options and the values of options that have names."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from endocal.calibration.methods.registry import METHODS
from endocal.calibration.spec import MODELS
from endocal.cli.app import COMMANDS
from endocal.jobs.correction import DEINTERLACE, STEREO
from endocal.jobs.export import KINDS
from endocal.remap.geometry import VIEWS
from endocal.remap.interpolation import TAPS
from endocal.zoom.table import LOOKUPS

ALL_COMMANDS = [name for names in COMMANDS.values() for name in names]


def completed(*words: str) -> list[str]:
    """What bash is told for the last word."""
    env = {
        **os.environ,
        "_ENDOCAL_COMPLETE": "complete_bash",
        "COMP_WORDS": " ".join(("endocal", *words)),
        "COMP_CWORD": str(len(words)),
    }
    command = [sys.executable, "-c", "from endocal.cli.app import main; main()"]
    return subprocess.check_output(command, env=env, text=True).split()


def test_commands() -> None:
    assert sorted(completed("")) == sorted(ALL_COMMANDS)
    assert completed("z") == ["zoomtable"]
    assert completed("synth", "") == ["board", "zoom", "clip"]


@pytest.mark.parametrize(
    ("words", "names"),
    [
        (("calibrate", "--method"), METHODS),
        (("zoomtable", "--method"), METHODS),
        (("calibrate", "--model"), MODELS),
        (("correct", "--view"), VIEWS),
        (("correct", "--interpolation"), TAPS),
        (("correct", "--stereo"), STEREO),
        (("correct", "--deinterlace"), DEINTERLACE),
        (("correct", "--lookup"), LOOKUPS),
        (("export", "--view"), VIEWS),
        (("export", "--to"), KINDS),
    ],
)
def test_values(words: tuple[str, ...], names: list[str]) -> None:
    assert sorted(completed(*words, "")) == sorted(names)
    first = sorted(names)[0]
    assert first in completed(*words, first[:2])


def test_options() -> None:
    assert completed("correct", "--zoom") == ["--zoom-log", "--zoom-from"]


def test_bash_completes_commands_and_files(tmp_path: Path) -> None:
    """As an interactive shell does it: the script that endocal prints, asked by bash itself."""
    bash = shutil.which("bash")
    if bash is None:
        pytest.skip("no bash")
    program = tmp_path / "endocal"
    code = f"#!{sys.executable}\nfrom endocal.cli.app import main\nmain()\n"
    program.write_text(code)
    program.chmod(0o755)
    (tmp_path / "board.png").touch()
    # Readline's own "complete" key, on a line that is typed in; -o default falls back on files.
    script = f"""
        cd {tmp_path}; PATH={tmp_path}:$PATH
        eval "$(_ENDOCAL_COMPLETE=source_bash endocal)"
        COMP_WORDS=(endocal zoom); COMP_CWORD=1; _endocal_completion endocal; echo "${{COMPREPLY[*]}}"
        COMP_WORDS=(endocal calibrate bo); COMP_CWORD=2; _endocal_completion endocal
        echo "[${{COMPREPLY[*]}}]"; complete -p endocal
    """
    out = subprocess.check_output([bash, "--norc", "-c", script], text=True).splitlines()
    assert out[0] == "zoomtable"
    assert out[1].strip("[]").split() in ([], ["board.png"])
    assert "-o default" in out[2]
