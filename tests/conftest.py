"""Fixtures for all tests: the real pictures, and the command line."""

from __future__ import annotations

import contextlib
import io
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import hypothesis
import pytest

from endocal.jobs.threads import limit_threads
from tests.browser import NAMES, Browser

ROOT = Path(__file__).resolve().parent.parent

# Before numpy is loaded: as a command does, and so that two workers do not wait for each other's threads.
limit_threads(0)

# Commands that tests start as processes load what the first of them compiled, whatever this one was told.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

# No deadline: a machine under load is no failure. The same examples each time, so that CI repeats itself.
hypothesis.settings.register_profile("endocal", deadline=None, derandomize=True)
hypothesis.settings.load_profile("endocal")


@pytest.fixture(scope="session")
def real_data() -> Path:
    """The folder of real pictures, which is no part of the project."""
    folder = Path(os.environ.get("ENDOCAL_REAL_DATA", ROOT.parent / "shared" / "data"))
    if not (folder / "boards").is_dir():
        message = f"no real pictures at {folder}: set ENDOCAL_REAL_DATA to their folder"
        if os.environ.get("CI"):
            pytest.fail(message)
        pytest.skip(message)
    return folder


@pytest.fixture(scope="session")
def sample_data() -> Path:
    """The folder of synthetic samples with known truth, part of the project."""
    return ROOT / "sample_data"


@pytest.fixture(scope="session")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Browser:
    """A headless Chromium. CI has to say aloud, by ENDOCAL_NO_CHROMIUM, that it has none."""
    program = next(filter(None, map(shutil.which, NAMES)), None)
    if program is None:
        message = f"no browser to look at pages with: none of {', '.join(NAMES)} is installed"
        if os.environ.get("CI") and not os.environ.get("ENDOCAL_NO_CHROMIUM"):
            pytest.fail(message)
        pytest.skip(message)
    return Browser(program, tmp_path_factory.mktemp("browser"))


@dataclass(frozen=True)
class CliResult:
    """How a command line ended: exit code, stdout as bytes and text, stderr as text."""

    code: int
    output: bytes
    err: str

    @property
    def out(self) -> str:
        return self.output.decode()

    def fails(self, code: int = 1) -> str:
        """Check that it failed as a user may see it: this code, one line or two, no traceback."""
        assert self.code == code, f"exit {self.code}: {self.err or self.out}"
        assert not self.output
        assert "Traceback" not in self.err
        lines = self.err.rstrip("\n").split("\n")
        assert len(lines) <= (2 if code == 2 else 1), self.err
        assert lines[0].strip()
        return lines[0]


@pytest.fixture
def endocal(monkeypatch: pytest.MonkeyPatch) -> Callable[..., CliResult]:
    """Run ``endocal`` in this process: ``endocal("show", path, stdin=b"...")``."""
    from endocal.cli.app import run

    def call(*args: str | os.PathLike[str], stdin: bytes = b"") -> CliResult:
        out = io.TextIOWrapper(io.BytesIO(), encoding="utf-8", write_through=True)
        err = io.StringIO()
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(stdin), encoding="utf-8"))
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            try:
                code = run([os.fspath(a) for a in args])
            except SystemExit as exit_:
                code = int(exit_.code or 0)
        out.flush()
        return CliResult(code, out.buffer.getvalue(), err.getvalue())  # type: ignore[attr-defined]

    return call


@pytest.fixture
def endocal_process() -> Callable[..., CliResult]:
    """Run ``endocal`` as a process of its own: for pipes, signals and what gets imported."""

    def call(
        *args: str | os.PathLike[str],
        stdin: bytes = b"",
        env: dict[str, str] | None = None,
        cwd: Path | None = None,
        timeout: float = 120,
    ) -> CliResult:
        done = subprocess.run(
            [sys.executable, "-m", "endocal", *args],
            input=stdin,
            capture_output=True,
            env={**os.environ, **(env or {})},
            cwd=cwd,
            timeout=timeout,
            check=False,
        )
        return CliResult(done.returncode, done.stdout, done.stderr.decode(errors="replace"))

    return call
