"""The option ``--report`` and what is checked of it before any work."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from ..errors import UsageError

Page = Annotated[
    Path | None,
    typer.Option(
        *("--report",),
        metavar="FILE",
        help="Write a page with pictures, for people (.html): can it be trusted, and why.",
        show_default=False,
    ),
]


def check_page(
    page: Path, output: Path, overwrite: bool, inputs: Sequence[Path], json: bool
) -> None:
    """Refuse a page that shares its place with another file, must not go there, or cannot be made at all."""
    from ..jobs.page_place import check_page_place

    if str(page) == "-" and (json or str(output) == "-"):
        raise UsageError("--report - shares stdout with another output: name a file")
    if str(page) != "-" and page.resolve() == output.resolve():
        raise UsageError(f"--report {page}: is also the output: give it another name")
    check_page_place(page, overwrite, inputs)
