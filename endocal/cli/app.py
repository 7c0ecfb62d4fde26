"""The ``endocal`` command: subcommands by name, errors to exit codes."""

from __future__ import annotations

import importlib
import os
import sys

import typer

from ..errors import EndocalError, UsageError

# In the order of --help. Each is a module of this package with a function ``command``.
COMMANDS: tuple[str, ...] = ()

app = typer.Typer(no_args_is_help=True, add_completion=True, pretty_exceptions_enable=False)


@app.callback(invoke_without_command=True)
def _root(
    version: bool = typer.Option(False, "--version", help="Print the version and exit."),
) -> None:
    """Calibrate a wide-angle zoom lens from one picture and correct its video."""
    if version:
        from .._version import __version__

        typer.echo(f"endocal {__version__}")
        raise typer.Exit


def _register() -> None:
    for name in COMMANDS:
        module = importlib.import_module(f".{name}", __package__)
        group = getattr(module, "group", None)
        if group is not None:
            app.add_typer(group, name=name)
        else:
            app.command(name)(module.command)


def main() -> None:
    """Run the command line: exit 0 done, 1 failed, 2 wrong usage, 130 interrupted."""
    _register()
    try:
        app()
    except EndocalError as error:
        if os.environ.get("ENDOCAL_DEBUG"):
            raise
        print(f"endocal: {error}", file=sys.stderr)
        sys.exit(2 if isinstance(error, UsageError) else 1)
    except KeyboardInterrupt:
        sys.exit(130)
