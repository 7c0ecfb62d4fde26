"""Outputs that are complete or not there: written beside their place, renamed when done."""

from __future__ import annotations

import contextlib
import contextvars
import errno
import os
import secrets
from collections.abc import Iterable, Iterator
from pathlib import Path

from ..errors import OutputError
from .names import PathLike, shown

_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
# What a file system without hard links answers (FAT, some network shares).
_NO_LINKS = (errno.EPERM, errno.ENOTSUP, errno.EOPNOTSUPP, errno.ENOSYS, errno.EMLINK, errno.EACCES)


# All temporary files begin so; a mark behind it says whose they are.
_PREFIX = ".endocal-"
_mark = contextvars.ContextVar("mark", default="")


@contextlib.contextmanager
def marked_temporaries(mark: str) -> Iterator[None]:
    """Put ``mark`` into the names of the block's temporary files, to know what a killed process left."""
    token = _mark.set(f"{mark}-")
    try:
        yield
    finally:
        _mark.reset(token)


def remove_temporaries(directory: PathLike, mark: str) -> int:
    """Remove the temporary files in a directory that bear ``mark`` and return how many they were."""
    removed = 0
    with contextlib.suppress(FileNotFoundError, NotADirectoryError):
        for path in Path(directory).glob(f"{_PREFIX}{mark}-*"):
            with contextlib.suppress(FileNotFoundError):
                path.unlink()
                removed += 1
    return removed


@contextlib.contextmanager
def atomic_output(
    path: PathLike, overwrite: bool = False, inputs: Iterable[PathLike] = ()
) -> Iterator[Path]:
    """Give a temporary path beside ``path``, of the same suffix; rename it there when the block succeeds.

    The temporary file exists and is empty at first. On any exception, an interrupt included, it is removed
    and ``path`` stays as it was. ``inputs`` are files that must not be written over, whatever
    ``overwrite`` says. Raises OutputError, before the block runs, for an output that exists (without
    ``overwrite``), that is an input, or whose directory is missing or not writable; and when the disk is
    full.
    """
    name = shown(path)
    place = _checked_place(path, overwrite, inputs)
    temporary = _temporary(place)
    # Made inside the try: an interrupt may come as soon as it is there.
    try:
        _reserve(temporary, name)
        yield temporary
        _sync(temporary)
        _move(temporary, place, overwrite, name)
    except OSError as error:
        if error.errno in _FULL:
            raise OutputError(f"{name}: the disk is full: {error.strerror}") from error
        raise
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink()


def check_output(path: PathLike, overwrite: bool = False, inputs: Iterable[PathLike] = ()) -> None:
    """Raise what ``atomic_output`` would, before the work rather than after it; ``-`` is always right."""
    if os.fspath(path) != "-":
        _checked_place(path, overwrite, inputs)


def _checked_place(path: PathLike, overwrite: bool, inputs: Iterable[PathLike]) -> Path:
    """Return where the output really goes, through links; OutputError where it must not go."""
    name = shown(path)
    if not os.fspath(path):
        raise OutputError("the output's name is empty")
    try:
        place = Path(os.path.realpath(path))
        if not place.parent.is_dir():
            raise OutputError(
                f"{name}: the directory {shown(place.parent)} does not exist: make it first"
            )
        if place.is_dir():
            raise OutputError(f"{name}: is a directory: name a file in it")
        for source in inputs:
            if place.exists() and os.path.exists(source) and os.path.samefile(place, source):
                raise OutputError(f"{name}: is also an input: give the output another name")
        if place.exists():
            if not place.is_file():
                raise OutputError(f"{name}: is no regular file: write to - for a pipe")
            if not overwrite:
                raise _exists(name)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise OutputError(f"{name}: cannot be written: {reason}") from None
    return place


def _temporary(place: Path) -> Path:
    """Return the path of a temporary file beside an output."""
    # Its own short name, since the final one may already be as long as the file system allows.
    suffix = place.suffix if len(place.suffix.encode()) <= 32 else ""
    return place.with_name(f"{_PREFIX}{_mark.get()}{secrets.token_hex(8)}{suffix}")


def _reserve(temporary: Path, name: str) -> None:
    """Make the empty temporary file, with the permissions that a new file gets here."""
    try:
        os.close(os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
    except OSError as error:
        raise OutputError(f"{name}: cannot be written: {error.strerror}") from None


def _sync(temporary: Path) -> None:
    """Bring the bytes to the disk before the name, so that a power cut leaves no hollow file."""
    descriptor = os.open(temporary, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno not in (errno.EINVAL, errno.ENOTSUP):
            raise
    finally:
        os.close(descriptor)


def _move(temporary: Path, place: Path, overwrite: bool, name: str) -> None:
    if overwrite:
        os.replace(temporary, place)
        return
    try:
        # Unlike a rename, a link never replaces a file that has appeared meanwhile.
        os.link(temporary, place)
    except FileExistsError:
        raise _exists(name) from None
    except OSError as error:
        if error.errno not in _NO_LINKS:
            raise
        if place.exists():
            raise _exists(name) from None
        os.replace(temporary, place)


def _exists(name: str) -> OutputError:
    return OutputError(f"{name}: exists already: give --overwrite, or another name")
