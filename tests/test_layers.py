"""The house keeps its floors: imports point down, heavy libraries stay in their rooms, all is shipped."""

from __future__ import annotations

import ast
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "endocal"

# First name below ``endocal`` -> floor. An import goes to a lower floor, or stays within its own room.
FLOORS = {
    "_version": 0,
    "errors": 0,
    "model": 1,
    "boundary": 2,
    "synth": 2,
    "calibration": 3,
    "zoom": 3,
    "remap": 3,
    "video": 3,
    "exchange": 4,
    "report": 4,
    "files": 4,
    "jobs": 5,
    "benchmarks": 5,
    "batch": 6,
    "cli": 7,
    "__main__": 8,
    "__init__": 8,
}
# The same within ``calibration``: from what is seen to what is told of the lens.
CALIBRATION = {
    "result": 0,
    "spec": 0,
    "straightness": 0,
    "image": 1,
    "measure": 2,
    "board": 3,
    "fit": 4,
    "hough": 4,
    "search": 4,
    "recorded": 4,
    "evaluate": 4,
    "quality": 5,
    "scene": 5,
    "methods": 6,
    "lens_fit": 6,
    "objective": 7,
    "outcome": 7,
    "calibrate": 8,
    "__init__": 8,
}
ROOMS = {"typer": "cli", "rich": "cli", "av": "video", "pyopencl": "remap"}
# Import name -> distribution, where they differ.
DISTRIBUTIONS = {"cv2": "opencv-python-headless", "tomli_w": "tomli-w"}


def modules() -> list[Path]:
    return sorted(PACKAGE.rglob("*.py"))


def place(path: Path) -> tuple[str, ...]:
    """The dotted name below ``endocal``, as parts: ("remap", "engine")."""
    return path.relative_to(PACKAGE).with_suffix("").parts


def imports(path: Path) -> Iterator[tuple[tuple[str, ...], bool]]:
    """Each imported module as parts, ``endocal`` in front of our own, and whether at module level."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    functions = [n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef)]
    inner = {id(node) for function in functions for node in ast.walk(function)}
    here = ("endocal", *place(path))
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield tuple(alias.name.split(".")), id(node) not in inner
        elif isinstance(node, ast.ImportFrom):
            base = here[: -node.level] if node.level else ()
            parts = (*base, *(node.module.split(".") if node.module else ()))
            for alias in node.names:
                yield (*parts, alias.name), id(node) not in inner


@pytest.mark.parametrize("path", modules(), ids=lambda p: "/".join(place(p)))
def test_imports_point_down(path: Path) -> None:
    room = place(path)[0]
    assert room in FLOORS, f"{room} has no floor in this test"
    for target, _ in imports(path):
        if target[0] != "endocal" or len(target) < 2 or target[1] == "__version__":
            continue
        assert target[1] in FLOORS, f"{'.'.join(target)} is no module of endocal"
        lower = FLOORS[target[1]] < FLOORS[room]
        assert lower or target[1] == room, f"{'/'.join(place(path))} imports {'.'.join(target)}"


@pytest.mark.parametrize(
    "path", sorted((PACKAGE / "calibration").rglob("*.py")), ids=lambda p: "/".join(place(p))
)
def test_imports_within_calibration_point_down(path: Path) -> None:
    room = place(path)[1]
    for target, _ in imports(path):
        if target[:2] == ("endocal", "calibration") and len(target) > 2 and target[2] != room:
            assert CALIBRATION[target[2]] < CALIBRATION[room], f"{path.name}: {'.'.join(target)}"


@pytest.mark.parametrize("path", modules(), ids=lambda p: "/".join(place(p)))
def test_heavy_libraries_stay_in_their_rooms(path: Path) -> None:
    room, name = place(path)[0], place(path)[-1]
    for target, _ in imports(path):
        owner = ROOMS.get(target[0])
        assert owner in (None, room), f"{'/'.join(place(path))} imports {target[0]}"
        if target[0] == "pyopencl":
            assert name.startswith("opencl"), f"{name} imports pyopencl"


def test_every_import_is_a_declared_dependency() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = [d for name, e in project["optional-dependencies"].items() if name != "dev" for d in e]
    required = {distribution_name(d) for d in project["dependencies"]}
    optional = {distribution_name(d) for d in extras}
    for path in modules():
        for target, at_module_level in imports(path):
            if target[0] == "endocal" or target[0] in sys.stdlib_module_names:
                continue
            name = DISTRIBUTIONS.get(target[0], target[0])
            allowed = required if at_module_level else required | optional
            assert name in allowed, f"{'/'.join(place(path))} imports {target[0]}"


def distribution_name(requirement: str) -> str:
    for separator in "[<>=!~; ":
        requirement = requirement.partition(separator)[0]
    return requirement.replace("_", "-")


def test_every_package_is_shipped() -> None:
    listed = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["packages"]
    there = {
        ".".join(("endocal", *p.parent.relative_to(PACKAGE).parts))
        for p in PACKAGE.rglob("__init__.py")
    }
    assert set(listed) == there | {"endocal.kernels"}


def test_every_kernel_is_shipped() -> None:
    files = [p for p in (ROOT / "kernels").iterdir() if p.suffix not in (".py", ".pyc")]
    kernels = [p for p in files if p.is_file()]
    assert kernels
    assert all(p.suffix == ".cl" for p in kernels)


@pytest.mark.parametrize(
    "path",
    [*modules(), *sorted((ROOT / "tests").rglob("*.py")), *sorted((ROOT / "kernels").glob("*.cl"))],
    ids=lambda p: str(p.relative_to(ROOT)),
)
def test_files_stay_readable_in_one_go(path: Path) -> None:
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 400
