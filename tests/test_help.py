"""Help comes quickly, for every command, with an example, and loads nothing heavy."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from typing import Any

import pytest
import typer

from endocal.cli.app import build
from endocal.cli.help import tidy

HEAVY = ("av", "cv2", "matplotlib", "numpy", "pyopencl", "scipy")

# What a process has loaded when it ends, on stderr, whatever its exit.
LIST_MODULES = """
import atexit, sys
atexit.register(lambda: print(*sorted(sys.modules), file=sys.stderr))
from endocal.cli.app import main
sys.argv = ["endocal", *sys.argv[1:]]
main()
"""


def commands() -> Iterator[tuple[tuple[str, ...], Any]]:
    """Each command as (its words, its command object)."""

    def walk(words: tuple[str, ...], command: Any) -> Iterator[tuple[tuple[str, ...], Any]]:
        if words:
            yield words, command
        for name, child in getattr(command, "commands", {}).items():
            yield from walk((*words, name), child)

    yield from walk((), typer.main.get_command(build()))


@pytest.mark.parametrize("args", [["--help"], ["--version"], ["show", "--help"], ["nonsense"]])
def test_help_loads_nothing_heavy(args: list[str]) -> None:
    done = subprocess.run(
        [sys.executable, "-c", LIST_MODULES, *args], capture_output=True, text=True, check=False
    )
    loaded = {name.partition(".")[0] for name in done.stderr.split()}
    assert "typer" in loaded
    assert loaded.isdisjoint(HEAVY)


def test_importing_the_package_loads_nothing_heavy() -> None:
    code = "import sys, endocal; print(*sys.modules)"
    loaded = subprocess.check_output([sys.executable, "-c", code], text=True).split()
    assert set(loaded).isdisjoint({*HEAVY, "typer", "rich"})


def test_every_command_and_option_is_explained() -> None:
    for words, command in commands():
        assert command.help, f"endocal {' '.join(words)} has no help"
        assert command.help.split("\n")[0].endswith("."), f"endocal {' '.join(words)}"
        for parameter in command.params:
            explained = getattr(parameter, "help", None)
            assert explained, f"endocal {' '.join(words)}: {parameter.name} has no help"


def test_every_command_has_an_example() -> None:
    for words, command in commands():
        line = " ".join(("endocal", *words))
        assert line in (command.epilog or ""), line


def test_help_fits_any_width_and_names_no_types(
    endocal: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    for words, _ in commands():
        for width in ("80", "120"):
            monkeypatch.setenv("COLUMNS", width)
            shown = endocal(*words, "--help").out
            assert not re.search(r"<(bool|str|int|float|path|list)", shown), words
            assert max(len(line) for line in shown.splitlines()) <= int(width)


def test_a_paragraph_of_help_is_broken_by_the_terminal_alone() -> None:
    root = typer.main.get_command(build())
    tidy(root)

    def check(command: Any) -> None:
        assert all("\n" not in paragraph for paragraph in command.help.split("\n\n"))
        for child in getattr(command, "commands", {}).values():
            check(child)

    check(root)


def test_help_shows_square_brackets(endocal: Callable[..., Any]) -> None:
    # Help goes through rich, which would swallow an unescaped [word] as a style.
    for words, command in commands():
        shown = endocal(*words, "--help").out
        for text in (command.help, command.epilog or ""):
            for word in text.split():
                if word.startswith("[") and word.endswith("]"):
                    assert word in shown, f"endocal {' '.join(words)} --help loses {word}"
