"""A progress bar on standard error, for people: where that is no terminal, nothing is shown."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..jobs.correction import Progress


@contextlib.contextmanager
def progress_bar(title: str, quiet: bool = False) -> Iterator[Callable[[Progress], None] | None]:
    """Show a bar with frames, rate and time left while the block runs; give the function that moves it.

    Gives None where nobody watches.
    """
    if quiet or not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        TaskProgressColumn,
        TextColumn,
        TimeRemainingColumn,
    )
    from rich.progress import Progress as Bar

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[rate]:.0f} fps"),
        TimeRemainingColumn(),
    )
    with Bar(*columns, console=Console(stderr=True), transient=True) as bar:
        # Names are shown as they are: rich would take square brackets in one for markup.
        task = bar.add_task(title.replace("[", r"\["), total=None, rate=0.0)

        def move(state: Progress) -> None:
            rate = state.frames / state.seconds if state.seconds > 0 else 0.0
            bar.update(task, completed=state.frames, total=state.total, rate=rate)

        yield move
