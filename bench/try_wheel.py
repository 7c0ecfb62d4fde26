"""Install a built wheel alone in an empty environment and correct a clip with it from another directory.

What an editable install hides shows here: files that the wheel lacks (kernels above all), dependencies
that nobody declared, paths that hold only in the checkout. ``python bench/try_wheel.py dist/*.whl``
"""

from __future__ import annotations

import os
import subprocess
import sys
import tarfile
import tempfile
import venv
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SAMPLES = ROOT / "sample_data"


def main() -> None:
    """Try the wheel given on the command line, and look into the sdist beside it."""
    wheel = Path(sys.argv[1]).resolve()
    kernels = sorted(p.name for p in (ROOT / "kernels").glob("*.cl"))
    check_contents(wheel, kernels)
    with tempfile.TemporaryDirectory() as folder:
        home = Path(folder)
        venv.create(home / "venv", with_pip=True)
        python = home / "venv" / "bin" / "python"
        pip = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        run([*pip, wheel], home)
        endocal = home / "venv" / "bin" / "endocal"
        run([endocal, "--version"], home)
        run([endocal, "calibrate", SAMPLES / "board-1.png", "-o", "cal.toml"], home)
        run([endocal, "correct", SAMPLES / "clip.mp4", "-c", "cal.toml", "-o", "out.mp4"], home)
        run([endocal, "correct", SAMPLES / "board-1.png", "-c", "cal.toml", "-o", "out.png"], home)
        # Without the extra `report` its absence is told, with what to do about it.
        bare = run([endocal, "report", "cal.toml"], home, fails=True)
        assert "endocal-toolchain[report]" in bare, bare
        assert (home / "out.mp4").stat().st_size > 0
        assert (home / "out.png").stat().st_size > 0
    print(f"{wheel.name}: installs alone, calibrates and corrects")


def check_contents(wheel: Path, kernels: list[str]) -> None:
    """Every kernel is in the wheel, and in the sdist beside it; so is the style of pages."""
    assert "endocal/report/style.css" in zipfile.ZipFile(wheel).namelist()
    inside = {
        Path(n).name for n in zipfile.ZipFile(wheel).namelist() if n.startswith("endocal/kernels/")
    }
    assert kernels, "no kernels in the checkout"
    assert inside >= set(kernels), f"the wheel lacks {set(kernels) - inside}"
    for sdist in wheel.parent.glob("*.tar.gz"):
        with tarfile.open(sdist) as archive:
            names = {Path(n).name for n in archive.getnames() if "/kernels/" in n}
        assert names >= set(kernels), f"the sdist lacks {set(kernels) - names}"


def run(command: list[str | Path], folder: Path, fails: bool = False) -> str:
    """Run a command in a folder, away from the checkout; its failure is ours, unless it is to fail.

    Returns what a command that is to fail says on standard error.
    """
    clean = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "VIRTUAL_ENV")}
    if not fails:
        subprocess.run(command, cwd=folder, env=clean, check=True)
        return ""
    done = subprocess.run(
        command, cwd=folder, env=clean, stderr=subprocess.PIPE, text=True, check=False
    )
    assert done.returncode == 1, f"{command[1]} was to fail"
    return done.stderr


if __name__ == "__main__":
    main()
