"""The number of threads that libraries may start, told before they are loaded."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from endocal.errors import UsageError
from endocal.jobs.correction import CorrectionSpec


def threads_of(code: str, **env: str) -> str:
    environment = {k: v for k, v in os.environ.items() if not k.endswith(("_COUNT", "_THREADS"))}
    return subprocess.run(
        [sys.executable, "-c", "from endocal.jobs.threads import limit_threads\n" + code],
        env=environment | env,
        capture_output=True,
        text=True,
        check=True,
    ).stdout.strip()


def test_libraries_keep_to_the_limit() -> None:
    code = "limit_threads(1); import cv2; print(cv2.getNumThreads())"
    assert threads_of(code) == "1"


def test_the_environment_goes_first_and_zero_sets_nothing() -> None:
    code = "limit_threads({}); import os; print(os.environ.get('POCL_MAX_PTHREAD_COUNT'))"
    assert threads_of(code.format(3), POCL_MAX_PTHREAD_COUNT="2") == "2"
    assert threads_of(code.format(3)) == "3"
    assert threads_of(code.format(0)) == "None"


def test_a_command_lets_linear_algebra_use_one() -> None:
    code = """
import os, sys, endocal.cli.app
endocal.cli.app.main = lambda: print(os.environ["OPENBLAS_NUM_THREADS"], "numpy" in sys.modules)
from endocal.cli.entry import main
main()"""
    assert threads_of(code) == "1 False"
    assert threads_of(code, OPENBLAS_NUM_THREADS="2") == "2 False"


@pytest.mark.parametrize("count", [-1, 257, 99999])
def test_more_threads_than_the_libraries_bear_are_refused(count: int) -> None:
    with pytest.raises(UsageError, match=f"--threads {count}: it is 1 to 256, or 0 for by cores"):
        CorrectionSpec("a.mp4", "b.mp4", "cal.toml", threads=count)
    assert CorrectionSpec("a.mp4", "b.mp4", "cal.toml", threads=256).threads == 256
