"""What PoCL and pyopencl need of the machine, provided before they are loaded: directories, and a linker.

PoCL writes compiled kernels, and all that it makes on the way to them, into its cache and loads them from
there. Where it cannot, it reports no device, fails to build, or aborts the process, and names no reason.
pyopencl has a cache of its own, which it works without if told to.
"""

from __future__ import annotations

import atexit
import logging
import os
import platform
import shutil
import sys
import tempfile
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from ..errors import DeviceError
from .pocl_linker import provide_linker

_CACHE = "POCL_CACHE_DIR"
# The kernels of a run take less than 1 MiB, and what is made on the way to them a few.
_ROOM = 16 << 20
_PROBE = 1 << 18
# pyopencl's: whether to do without its cache, and a name that it gives itself.
_WITHOUT_CACHE, _PYOPENCL_HOME = "PYOPENCL_NO_CACHE", "PYOPENCL_HOME"
_TEMPORARY = ("TMPDIR", "TEMP", "TMP", "XDG_RUNTIME_DIR")


@dataclass(frozen=True)
class PoclSetup:
    """What was found: ``flaw`` says why PoCL's own cache will not do (None where it will), ``kernels`` is
    where its kernels go (None where no directory will do).
    """

    cache: str
    flaw: str | None
    kernels: str | None

    @property
    def trouble(self) -> str | None:
        """Why PoCL cannot work, and what to do, in one line; None where it can."""
        if self.flaw is None or self.kernels is not None:
            return None
        return (
            f"PoCL cannot keep its kernels in {self.cache or repr('')} ({self.flaw}), nor in any temporary"
            f" directory: set {_CACHE} to a directory that can be written and executed from, or pass"
            " --device numpy"
        )


@cache
def prepare_pocl() -> PoclSetup:
    """Set in the environment what PoCL and pyopencl read there: once, before they are imported and loaded,
    and while no other thread reads it.

    Where its cache will not do, kernels go to a private directory that lives as long as the process.
    """
    _prepare_pyopencl()
    wanted = cache_folder()
    if not sys.platform.startswith("linux"):
        return PoclSetup(wanted, None, wanted)
    flaw = find_flaw(wanted)
    private = _private_folder([] if flaw else [wanted])
    if flaw is None:
        kernels: str | None = wanted
    else:
        kernels = private
        if private is not None:
            os.environ[_CACHE] = kernels = str(Path(private, "kernels"))
    if private is not None and platform.machine() == "x86_64":
        provide_linker(Path(private))
    return PoclSetup(wanted, flaw, kernels)


@cache
def require_pocl() -> None:
    """Tell once where kernels go if not to the cache; raises DeviceError where they can go nowhere."""
    setup = prepare_pocl()
    if setup.trouble is not None:
        raise DeviceError(setup.trouble)
    if setup.flaw is not None:
        # Without any setting of logging this is a line on stderr.
        logging.getLogger(__name__).warning(
            "endocal: note: PoCL cannot keep its kernels in %s (%s): they are compiled anew in every run;"
            " %s names another directory",
            setup.cache or repr(""),
            setup.flaw,
            _CACHE,
        )


def cache_folder() -> str:
    """Return the directory that PoCL keeps its kernels in, by its own rules."""
    named = os.environ.get(_CACHE)
    if named is not None:
        return named
    home = os.environ.get("HOME")
    base = os.environ.get("XDG_CACHE_HOME") or ("/tmp" if home is None else f"{home}/.cache")
    return f"{base}/pocl/kcache"


def _prepare_pyopencl() -> None:
    found = find_spec("pyopencl")
    if found is not None and found.origin is not None:
        # As pyopencl does while it is imported, which may be in a thread: what is there already, the
        # environment is not laid out anew for.
        os.environ[_PYOPENCL_HOME] = os.path.dirname(os.path.abspath(found.origin))
    base = os.environ.get("XDG_CACHE_HOME", "").strip() or os.path.expanduser("~/.cache")
    if sys.platform.startswith("linux") and find_flaw(f"{base}/pytools", for_programs=False):
        os.environ.setdefault(_WITHOUT_CACHE, "1")


def find_flaw(folder: str, room: int = _ROOM, for_programs: bool = True) -> str | None:
    """Say why nothing can be kept in a directory, which is made if it is not there; None if it can.

    ``room`` is in bytes; ``for_programs`` asks for a file system that programs are loaded from.
    """
    try:
        os.makedirs(folder, mode=0o700, exist_ok=True)
        # Without a name where the file system can: nothing is left, however the process ends.
        with tempfile.TemporaryFile(dir=folder) as probe:
            probe.write(bytes(_PROBE))
        facts = os.statvfs(folder)
    except OSError as error:
        return error.strerror or str(error)
    if for_programs and facts.f_flag & os.ST_NOEXEC:
        return "mounted noexec"
    # Some network file systems do not tell their size.
    if facts.f_blocks and facts.f_bavail * facts.f_frsize < room:
        return f"less than {room >> 20} MiB free"
    return None


def _private_folder(last: list[str]) -> str | None:
    """Make a directory that is removed at exit, where there is one to make it in; ``last`` is tried last."""
    named = [os.environ[name] for name in _TEMPORARY if os.environ.get(name)]
    for place in (*named, "/tmp", "/var/tmp", "/dev/shm", *last):
        if os.path.isdir(place) and find_flaw(place) is None:
            folder = tempfile.mkdtemp(prefix="endocal-pocl-", dir=place)
            atexit.register(shutil.rmtree, folder, ignore_errors=True)
            return folder
    return None
