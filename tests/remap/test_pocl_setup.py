"""Where PoCL keeps its kernels: its cache, a private directory, or a line that says what is wrong."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from endocal.errors import DeviceError
from endocal.remap import pocl_setup
from endocal.remap.pocl_setup import cache_folder, find_flaw, prepare_pocl, require_pocl

pytestmark = pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="set up on Linux alone"
)

# A directory in which not even root can make anything.
NOWHERE = "/proc/nowhere"


@pytest.fixture
def fresh(monkeypatch):
    """A process that has not looked yet; the environment is put back afterwards."""
    for name in ("POCL_CACHE_DIR", "COMPILER_PATH", "PYOPENCL_NO_CACHE", "PYOPENCL_HOME"):
        monkeypatch.setenv(name, "")
        monkeypatch.delenv(name)
    for function in (prepare_pocl, require_pocl):
        monkeypatch.setattr(pocl_setup, function.__name__, function.__wrapped__)


@pytest.mark.parametrize(
    ("given", "folder"),
    [
        ({"POCL_CACHE_DIR": "/a", "XDG_CACHE_HOME": "/b", "HOME": "/c"}, "/a"),
        ({"XDG_CACHE_HOME": "/b", "HOME": "/c"}, "/b/pocl/kcache"),
        ({"XDG_CACHE_HOME": "", "HOME": "/c"}, "/c/.cache/pocl/kcache"),
        ({}, "/tmp/pocl/kcache"),
    ],
)
def test_the_cache_is_found_by_pocls_own_rules(monkeypatch, given, folder):
    for name in ("POCL_CACHE_DIR", "XDG_CACHE_HOME", "HOME"):
        monkeypatch.delenv(name, raising=False)
    for name, value in given.items():
        monkeypatch.setenv(name, value)
    assert cache_folder() == folder


def test_flaws_are_told(tmp_path, monkeypatch):
    assert find_flaw(str(tmp_path / "made" / "here")) is None
    assert list((tmp_path / "made" / "here").iterdir()) == []
    (tmp_path / "file").touch()
    for folder in (NOWHERE, "", str(tmp_path / "file"), str(tmp_path / "file" / "below")):
        assert find_flaw(folder), folder
    assert "MiB free" in (find_flaw(str(tmp_path), room=1 << 60) or "")
    facts = os.statvfs(tmp_path)
    noexec = os.statvfs_result((*facts[:8], facts.f_flag | os.ST_NOEXEC, facts[9]))
    monkeypatch.setattr(os, "statvfs", lambda folder: noexec)
    assert find_flaw(str(tmp_path)) == "mounted noexec"
    assert find_flaw(str(tmp_path), for_programs=False) is None


def test_a_cache_that_will_do_is_left_alone(fresh, monkeypatch, tmp_path, caplog):
    monkeypatch.setenv("POCL_CACHE_DIR", str(tmp_path / "kernels"))
    assert pocl_setup.prepare_pocl().kernels == str(tmp_path / "kernels")
    assert os.environ["POCL_CACHE_DIR"] == str(tmp_path / "kernels")
    pocl_setup.require_pocl()
    assert not caplog.records


def test_where_nothing_can_be_written_one_line_names_the_cache(fresh, monkeypatch):
    monkeypatch.setenv("POCL_CACHE_DIR", NOWHERE)
    monkeypatch.setattr(pocl_setup, "find_flaw", lambda *a, **k: "Read-only file system")
    with pytest.raises(
        DeviceError, match=rf"{NOWHERE} .Read-only file system.*POCL_CACHE_DIR"
    ) as e:
        pocl_setup.require_pocl()
    assert "\n" not in str(e.value)


def test_without_temporary_directories_the_linker_lies_in_the_cache(fresh, monkeypatch, tmp_path):
    monkeypatch.setenv("POCL_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(
        pocl_setup, "find_flaw", lambda f, *a, **k: None if f == str(tmp_path) else "Read-only"
    )
    assert pocl_setup.prepare_pocl().trouble is None
    if sys.platform == "linux" and os.uname().machine == "x86_64":
        assert Path(os.environ["COMPILER_PATH"], "ld").parent.parent == tmp_path


@pytest.mark.parametrize("given", [{"POCL_CACHE_DIR": NOWHERE}, {"HOME": NOWHERE}])
def test_kernels_are_built_and_cleared_away_where_no_cache_can_be(tmp_path, given):
    script = (
        "from endocal.model import DivisionModel\n"
        "from endocal.remap.remapper import Remapper\n"
        "import numpy as np\n"
        "picture = np.full((16, 16), 99, np.uint8)\n"
        "model = DivisionModel(-1e-3, (8.0, 8.0), (16, 16))\n"
        "for _ in range(2): assert Remapper(model, device='Portable').apply(picture)[8, 8] == 99\n"
    )
    hidden = ("POCL_CACHE_DIR", "XDG_CACHE_HOME", "COMPILER_PATH", "PYOPENCL_NO_CACHE")
    environment = {k: v for k, v in os.environ.items() if k not in hidden}
    environment |= {"TMPDIR": str(tmp_path), **given}
    done = subprocess.run(
        [sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    (line,) = done.stderr.splitlines()
    assert line.startswith(f"endocal: note: PoCL cannot keep its kernels in {NOWHERE}")
    assert list(tmp_path.iterdir()) == []


def test_a_thread_that_loads_the_device_adds_nothing_to_the_environment():
    # Other threads' C libraries may be reading it, which then is undefined.
    script = (
        "import os, sys, threading\n"
        "from endocal.remap.engine import load_device, prepare_device\n"
        "prepare_device('auto')\n"
        "there = set(os.environb)\n"
        "added = []\n"
        "def hook(event, values):\n"
        "    if event == 'os.unsetenv' or event == 'os.putenv' and values[0] not in there:\n"
        "        added.append(values[0])\n"
        "sys.addaudithook(hook)\n"
        "thread = threading.Thread(target=load_device, args=('auto',))\n"
        "thread.start()\n"
        "thread.join()\n"
        "assert 'pyopencl' in sys.modules\n"
        "assert not added, added\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
