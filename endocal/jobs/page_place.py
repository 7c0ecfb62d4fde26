"""Where a page may go: over no input, and under no name of a file of another kind."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import PurePath

from ..errors import UsageError
from ..files import check_output
from ..files.names import PathLike, shown
from ..report.figures import require_figures
from .pipe import PIPE

# A name without a suffix is taken, too: no program opens it as something else.
PAGE_SUFFIXES = (".html", ".htm")


def check_page_place(
    page: PathLike, overwrite: bool = False, inputs: Iterable[PathLike | None] = ()
) -> None:
    """Refuse a page, before any work, that could not be made or must not go there; ``-`` is stdout.

    Raises EndocalError where matplotlib is missing, OutputError for a page that is one of ``inputs``, exists
    (without ``overwrite``) or cannot be written, and UsageError for the name of a file of another kind.
    """
    require_figures()
    check_output(page, overwrite, [i for i in inputs if i is not None and os.fspath(i) != PIPE])
    check_page_name(os.fspath(page), shown(page))


def check_page_name(page: str, name: str) -> None:
    """Refuse a page whose suffix is that of a file of another kind; ``name`` is what the error calls it."""
    suffix = PurePath(page).suffix
    if suffix and suffix.lower() not in PAGE_SUFFIXES:
        raise UsageError(f"{name}: a report is an HTML page: name it .html")
