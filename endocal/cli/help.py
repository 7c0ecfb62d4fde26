"""Help as people read it: whole paragraphs, and no name of a type where no value is asked for."""

from __future__ import annotations

from typing import Any

import typer


def tidy(command: Any, parent: Any = None) -> None:
    """Make the help of a command, and of those below it, fit any terminal's width.

    A docstring's line breaks are those of the source; each paragraph becomes one line. Flags and arguments
    lose the type that typer prints beside them: a flag takes none, and an argument's name says it. What is
    a number and has no name of its own is an N.
    """
    if command.help:
        command.help = "\n\n".join(" ".join(p.split()) for p in command.help.split("\n\n"))
    context = typer.Context(command, parent=parent, **(command.context_settings or {}))
    for parameter in command.get_params(context):
        if parameter.param_type_name == "argument":
            if hasattr(parameter, "display_type_rich"):
                parameter.display_type_rich = _nothing
        elif parameter.is_flag:
            parameter.metavar = ""
        elif parameter.metavar is None:
            parameter.metavar = "N"
    for child in getattr(command, "commands", {}).values():
        tidy(child, context)


def _nothing(ctx: Any) -> None:
    return None
