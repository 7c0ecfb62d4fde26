"""What converts options without typer's converter gives what that gives, and the same refusals."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Annotated, Any

import pytest
import typer

from endocal.calibration.result import Calibration
from endocal.cli import plain_values
from endocal.cli.plain_values import convert_plainly
from endocal.files import save
from endocal.model import DivisionModel
from tests.video.clips import Clip


def values_of(args: list[str], plainly: bool) -> tuple[Any, str]:
    """The values that a command gets, or what it is refused with."""
    got: dict[str, Any] = {}

    def command(
        text: str,
        more: Annotated[list[str] | None, typer.Argument()] = None,
        number: int = 3,
        real: float | None = None,
        few: Annotated[int, typer.Option(min=0, max=9)] = 1,
        path: Path | None = None,
        paths: list[Path] | None = None,
        flag: bool = False,
    ) -> None:
        got.update(locals())

    app = typer.Typer(add_completion=False)
    app.command()(command)
    made = typer.main.get_command(app)
    if plainly:
        convert_plainly(made)
    try:
        made.main(args=args, prog_name="x", standalone_mode=False)
    except Exception as error:
        return None, f"{type(error).__name__}: {error.format_message()}"
    got.pop("got", None)
    return got, ""


@pytest.mark.parametrize(
    "words",
    [
        "a",
        "a b c",
        "a --number 12 --real 1.5e-3 --few 9 --flag",
        "a --number -7 --real .5 --real 2. --few 0",
        "a --real inf",
        "a --real 1_000 --number 1_0",
        "a --path none/such --path other --paths p --paths q",
        "a --path . --paths .",
        "-- - -b",
        "a --number 1.0",
        "a --number 1.5",
        "a --number x",
        "a --number=",
        "a --real 1,5",
        "a --real 1e400",
        "a --number 99999999999999999999",
        "a --few 10",
        "a --few -1",
        "",
    ],
)
def test_it_converts_and_refuses_as_typer_does(words: str) -> None:
    args = words.split()
    assert values_of(args, plainly=True) == values_of(args, plainly=False)


@pytest.mark.parametrize("typers", [False, True])
def test_a_file_that_cannot_be_read_is_the_jobs_to_refuse(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, typers: bool
) -> None:
    # Root may read anything.
    monkeypatch.setattr(os, "access", lambda *args, **options: False)
    if typers:
        monkeypatch.setattr(plain_values, "_plain", lambda value, kind: None)
    got, words = values_of(["a", "--path", str(tmp_path)], plainly=True)
    assert got is not None, words
    assert got["path"] == tmp_path


def test_a_correction_loads_no_converter_and_nothing_for_pictures(tmp_path: Path) -> None:
    code = "import sys; from endocal.cli.app import run; code = run(sys.argv[1:]); "
    code += "print(code, *{m.split('.')[0] for m in sys.modules})"
    clip, lens = Clip(frames=3, codec="mpeg4").make(tmp_path / "clip.mp4"), tmp_path / "lens.toml"
    save(Calibration(DivisionModel(0.0, (9.0, 9.0), Clip.size)), lens)
    words = ["correct", clip, "-o", tmp_path / "a.mp4", "-c", lens]
    words += ["--quiet", "--device", "numpy"]
    done = subprocess.run(
        [sys.executable, "-c", code, *map(str, words)], capture_output=True, text=True, check=True
    )
    first, *modules = done.stdout.split()
    assert first == "0", done.stderr
    assert not {"pydantic", "cv2", "scipy", "matplotlib", "rich"} & set(modules)
