"""Documentation that cannot drift: the command page is the commands' own help, links lead somewhere."""

from __future__ import annotations

import contextlib
import importlib
import re
import runpy
import shlex
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from endocal.calibration import quality as q
from endocal.cli.app import COMMANDS

ROOT = Path(__file__).resolve().parent.parent
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")])


def test_the_command_page_is_the_help() -> None:
    page = runpy.run_path(str(ROOT / "docs" / "generate_cli.py"))["page"]()
    assert (ROOT / "docs" / "cli.md").read_text() == page, "run: make docs"


def test_every_command_is_in_the_readme() -> None:
    readme = (ROOT / "README.md").read_text()
    for names in COMMANDS.values():
        for name in names:
            assert f"endocal {name}" in readme, name


@pytest.mark.parametrize("listing", ["README.md", "docs/index.md"])
def test_every_page_is_listed(listing: str) -> None:
    text = (ROOT / listing).read_text()
    for page in (ROOT / "docs").glob("*.md"):
        link = page.relative_to((ROOT / listing).parent).as_posix()
        assert f"({link})" in text or page == ROOT / listing, page.name


def test_the_readme_is_right_about_python(
    sample_data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("board-2.png", "zoom.truth.toml"):
        shutil.copy(sample_data / name, tmp_path)
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    assert blocks
    for block in blocks:
        names: dict[str, Any] = {}
        exec(block, names)
        assert names["corrected"].shape == names["picture"].shape
        assert names["calibration"].quality.verdict == "good"


def test_the_first_five_minutes_go_as_written(
    endocal: Callable[..., Any], sample_data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    readme = (ROOT / "README.md").read_text()
    (section,) = re.findall(r"^## The first five minutes\n(.*?)^## ", readme, re.DOTALL | re.M)
    commands = re.findall(r"^\$ (.*?)(?: +#.*)?$", section, re.MULTILINE)
    assert commands[:2] == [
        "make install && source .venv/bin/activate",
        "cp -r sample_data /tmp/first && cd /tmp/first",
    ]
    monkeypatch.chdir(shutil.copytree(sample_data, tmp_path / "first"))
    told = ""
    for command in commands[2:]:
        name, *words = shlex.split(command)
        assert name == "endocal"
        done = endocal(*words)
        assert done.code == 0, done.err
        told += done.err
    # Another machine has another device and speed, and may round a last digit otherwise.
    lines = re.findall(r"^endocal: .*?(?=, in \d| on |$)", section, re.MULTILINE)
    assert len(lines) > 10
    for line in lines:
        assert _without_numbers(line) in _without_numbers(told)


def _without_numbers(text: str) -> str:
    return re.sub(r"[-+]?\d[\d.]*(e[-+]\d+)?", "#", text)


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_links_lead_to_files_that_exist(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#]+?)(?:#[^)]*)?\)", page.read_text()):
        if "://" not in target:
            assert (page.parent / target).exists(), target


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_modules_that_the_pages_name_exist(page: Path) -> None:
    # `calibration/fit.py` in a page is a path below endocal/, tests/ or the root.
    for name in re.findall(r"`([\w/]+\.(?:py|cl))(?:::\w+)?`", page.read_text()):
        places = [ROOT / name, ROOT / "endocal" / name]
        assert any(p.exists() for p in places), f"{page.name} names {name}"


def test_the_table_of_the_verdict_has_the_thresholds() -> None:
    page = (ROOT / "docs" / "method.md").read_text()
    rows = dict(re.findall(r"^\| `(failed|doubtful)` \|(.*)\|$", page, re.MULTILINE))
    for words in (
        f"fewer than {q.FAILED_LINES} lines",
        f"stay {q.FAILED_ROUGH:g} px from straight",
        f"stay {q.FAILED_WITHOUT_BOARD:g} px from straight",
        f"fewer than {q.FEW_LINES} lines or less than {q.LITTLE_WITHOUT_BOARD:.0%}",
        f"more than {q.FAILED_ASTRAY:g} standard deviations",
    ):
        assert words.replace("%", " %") in rows["failed"]
    for words in (
        f"fewer than {q.FEW_LINES} lines",
        f"less than {q.POOR_COVERAGE:.0%} of the way",
        f"bent by {q.BENT:g} px",
        f"{q.ROUGH:g} px from straight by noise, {q.ROUGH_WITHOUT_BOARD:g} px without a chessboard",
        f"less than {q.LITTLE_EXPLAINED:.0%} of the edge points",
        f"without a chessboard less than {q.LITTLE_WITHOUT_BOARD:.0%}",
        f"more than {q.MANY_OUTLYING:.0%} of the points beyond five standard deviations",
        f"moves the farthest points by {q.FINEST:g} px",
        f"λ over {q.WEAK_LAMBDA:.0%}",
        f"centre over {q.WEAK_CENTER * 100:g}%",
        f"more than {q.ASTRAY:g} standard deviations",
        f"less than {q.NEAR_FOLD - 1:.0%} beyond",
    ):
        assert words.replace("%", " %") in rows["doubtful"]


def test_messages_that_the_troubleshooting_explains_exist() -> None:
    sources = " ".join(p.read_text() for p in (ROOT / "endocal").rglob("*.py"))
    # A message may be split over two lines of source: join adjacent string literals.
    joined = re.sub(r'"\s+f?"', "", sources)
    page = (ROOT / "docs" / "troubleshooting.md").read_text()
    messages = re.findall(r"^### `(.+)`$", page, re.MULTILINE)
    assert messages
    for message in messages:
        assert message in joined, message


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_functions_that_the_pages_name_exist(page: Path) -> None:
    for name in re.findall(r"`(endocal(?:\.\w+)+)(?:\(.*?\))?`", page.read_text()):
        parts = name.split(".")
        for cut in range(len(parts), 0, -1):
            with contextlib.suppress(ModuleNotFoundError):
                found: object = importlib.import_module(".".join(parts[:cut]))
                break
        for attribute in parts[cut:]:
            assert hasattr(found, attribute), f"{page.name} names {name}"
            found = getattr(found, attribute)
