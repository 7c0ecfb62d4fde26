"""Write docs/cli.md from the commands themselves: ``python docs/generate_cli.py`` (``--check`` compares)."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import typer

from endocal.cli.app import COMMANDS, build

PAGE = Path(__file__).with_name("cli.md")

HEAD = """\
# The command line

Made from the commands' own help by `docs/generate_cli.py`; a test compares. `endocal COMMAND --help`
prints the same in the terminal.

Data goes to stdout, everything else (progress, notes, warnings) to stderr. `-` is stdin or stdout.
Exit codes: 0 done, 1 failed (one line says what, where, and what to do), 2 wrong usage, 130 interrupted.
`ENDOCAL_DEBUG=1` shows the traceback behind an error. An output that exists is refused without
`--overwrite`, and appears under its name only when complete.
`endocal --install-completion` makes the shell complete commands and options.
"""


def page() -> str:
    """Return the whole page."""
    root = typer.main.get_command(build())
    children: dict[str, Any] = root.commands  # type: ignore[attr-defined]
    parts = [HEAD]
    for panel, names in COMMANDS.items():
        if names:
            links = "\n".join(
                f"- [`endocal {n}`](#endocal-{n}): {summary(children[n])}" for n in names
            )
            parts.append(f"**{panel}**\n\n{links}\n")
    for names in COMMANDS.values():
        for name in names:
            parts += sections((name,), children[name])
    return "\n".join(parts)


def summary(command: Any) -> str:
    """Return the first line of a command's help."""
    return " ".join(command.help.split("\n\n")[0].split())


def sections(words: tuple[str, ...], command: Any) -> Iterator[str]:
    """Yield the sections of a command and of the commands below it."""
    name = " ".join(("endocal", *words))
    paragraphs = [" ".join(p.split()) for p in command.help.split("\n\n")]
    yield f"{'#' * (len(words) + 1)} {name}\n\n" + "\n\n".join(paragraphs) + "\n"
    children = getattr(command, "commands", {})
    if not children:
        yield f"```\n{usage(name, command)}\n```\n\n{table(command)}"
    if command.epilog:
        _, *examples = command.epilog.split("\n\n")
        yield "Examples:\n\n```sh\n" + "\n".join(examples) + "\n```\n"
    for child_name, child in children.items():
        yield from sections((*words, child_name), child)


def usage(name: str, command: Any) -> str:
    """Return the usage line."""
    arguments = []
    for p in command.params:
        if p.param_type_name == "argument":
            word = (p.metavar or p.name.upper()).removesuffix("...") + "..." * (p.nargs == -1)
            arguments.append(word if p.required or "..." in word else f"[{word}]")
    return " ".join([name, *arguments, "[OPTIONS]"])


def table(command: Any) -> str:
    """Return the arguments and options as a Markdown table."""
    rows = ["| argument or option | meaning | default |", "|---|---|---|"]
    for p in command.params:
        if getattr(p, "hidden", False) or p.name == "help":
            continue
        rows.append(f"| {cell(label(p))} | {cell(p.help or '')} | {cell(default(p))} |")
    return "\n".join(rows) + "\n"


def label(parameter: Any) -> str:
    """Return how a parameter is written: ``-c``, ``--config FILE``."""
    if parameter.param_type_name == "argument":
        return f"`{parameter.metavar or parameter.name.upper()}`"
    names = ", ".join(f"`{o}`" for o in [*parameter.opts, *parameter.secondary_opts])
    return names if parameter.is_flag else f"{names} {metavar(parameter)}"


def metavar(parameter: Any) -> str:
    """Return the word for an option's value."""
    return f"*{parameter.metavar or 'N'}*"


def default(parameter: Any) -> str:
    """Return the default in words."""
    value = parameter.default
    if parameter.required:
        return "required"
    if value is None or value is False or callable(value) or value in ((), [], ""):
        return ""
    return f"`{getattr(value, 'value', value)}`"


def cell(text: str) -> str:
    """Return text for a table cell: one line, bars escaped."""
    return " ".join(text.split()).replace("|", "\\|")


def main() -> None:
    """Write the page, or with ``--check`` exit 1 where it is out of date."""
    text = page()
    if "--check" in sys.argv[1:]:
        sys.exit(text != PAGE.read_text(encoding="utf-8"))
    PAGE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
