"""File names as messages show them."""

from __future__ import annotations

import os

PathLike = str | os.PathLike[str]

# What there is to do about a file that is not there.
NO_SUCH_FILE = "no such file: check its name"


def shown(path: PathLike) -> str:
    """Return a path on one line: as it is, or quoted and escaped where it holds unprintable characters."""
    name = os.fspath(path)
    return name if name.isprintable() and name else repr(name)


def as_text(name: str) -> str:
    """Return a file's name as documents hold it: its bytes that are no valid Unicode are question marks."""
    return name.encode("utf-8", "replace").decode("utf-8")
