"""The pictures that a calibration names: found by name, proved by their SHA-256."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

from ..calibration.result import SourceImage
from ..errors import InputError
from ..files import read_picture_bytes
from ..files.names import as_text, shown


def find_picture(image: SourceImage, file: str, folder: str | None = None) -> str:
    """Return the path of the picture of that name and SHA-256, which the calibration ``file`` names.

    It is looked for beside ``file`` (``-`` is stdin), or anywhere below ``folder``. Raises InputError where
    it is not there, is another one, or has no SHA-256 on record.
    """
    name = "<stdin>" if file == "-" else shown(file)
    if not image.sha256:
        raise InputError(
            f"{name}: holds no SHA-256 of {shown(image.file)}, so that nothing proves it"
        )
    candidates = _candidates(Path(image.file).name, file, folder)
    for path in candidates:
        if hashlib.sha256(read_picture_bytes(path)).hexdigest() == image.sha256.lower():
            return str(path)
    if candidates:
        raise InputError(
            f"{shown(candidates[0])}: is not the picture that {name} was made from: its SHA-256 differs"
        )
    where = f"below {shown(folder)}" if folder else f"beside {name}"
    raise InputError(
        f"{name}: its picture {shown(image.file)} is not {where}: name its folder with --images DIR"
    )


def _candidates(picture: str, file: str, folder: str | None) -> list[Path]:
    """The files of that name beside the calibration, or anywhere below the folder of pictures."""
    if folder is None:
        parent = Path() if file == "-" else Path(file).parent
        if (parent / picture).is_file():
            return [parent / picture]
        return sorted(path for path in _files_in(parent) if _is_called(path.name, picture))
    if not Path(folder).is_dir():
        raise InputError(f"{shown(folder)}: no such folder of pictures: check its name")
    try:
        os.scandir(folder).close()
    except OSError as error:
        raise InputError(f"{shown(folder)}: cannot be read: {error.strerror}") from None
    found = ((at, name) for at, _, files in os.walk(folder) for name in files)
    return sorted(Path(at) / name for at, name in found if _is_called(name, picture))


def _files_in(folder: Path) -> list[Path]:
    try:
        return [path for path in folder.iterdir() if path.is_file()]
    except OSError:
        return []


def _is_called(name: str, picture: str) -> bool:
    """Say whether a file's name is the recorded one, in which question marks may stand for any bytes."""
    return as_text(name) == picture
