"""The ``endocal`` command: subcommands by name, errors to exit codes."""

from __future__ import annotations

import atexit
import contextlib
import errno
import gc
import importlib
import io
import os
import signal
import sys
import threading
import traceback
import warnings
from collections.abc import Callable, Sequence
from typing import Any, NoReturn

import typer

from ..errors import EndocalError, UsageError
from .help import tidy
from .plain_values import convert_plainly

# The panels of --help and the commands in each, in order. Each is a module of this package with a function
# ``command`` or a typer app ``group``, and, if it likes, command lines in ``EXAMPLES`` for its help.
COMMANDS: dict[str, tuple[str, ...]] = {
    "Calibrate": ("calibrate", "zoomtable"),
    "Correct": ("correct", "batch"),
    "Look and convert": ("show", "report", "boundary", "export", "import"),
    "Check and measure": ("evaluate", "compare", "check", "synth", "devices", "bench"),
}

# Set by the shell when it asks for completions; typer answers instead of running anything.
_COMPLETION = "_ENDOCAL_COMPLETE"

# The way from a picture to a corrected video, and what a script needs to know.
_EPILOG = "\n\n".join(
    (
        "Examples:",
        "endocal calibrate board.png -o cal.toml",
        "endocal correct surgery.mp4 -o corrected.mp4 -c cal.toml",
        "Exit codes: 0 done, 1 failed, 2 wrong usage, 130 interrupted. Data goes to stdout, all else to"
        " stderr; - is stdin or stdout. endocal COMMAND --help says more.",
    )
)

DONE, FAILED, WRONG_USAGE, INTERRUPTED = 0, 1, 2, 130


def build(names: Sequence[str] | None = None) -> typer.Typer:
    """Return the application with all its commands, or with those named alone."""
    app = typer.Typer(
        add_completion=True,
        pretty_exceptions_enable=False,
        epilog=_EPILOG,
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    app.callback(invoke_without_command=True)(_root)
    for panel, commands in COMMANDS.items():
        for name in commands:
            if names is None or name in names:
                _add(app, panel, name)
    return app


def run(args: Sequence[str]) -> int:
    """Run one command line and return the exit code: 0 done, 1 failed, 2 wrong usage, 130 interrupted."""
    try:
        code = _invoke(args)
        sys.stdout.flush()
        return code
    except EndocalError as error:
        return _fail(str(error), WRONG_USAGE if isinstance(error, UsageError) else FAILED)
    except KeyboardInterrupt:
        return _fail("interrupted", INTERRUPTED)
    except MemoryError:
        return _fail("out of memory", FAILED)
    except OSError as error:
        if isinstance(error, BrokenPipeError) and _stdout_is_closed():
            return _end_quietly()
        if error.filename is None and _stdout_refuses():
            _forget_stdout()
            return _fail(_describe_output(error), FAILED)
        return _fail(_describe(error), FAILED)
    except Exception as error:
        words = f"internal error: {type(error).__name__}: {error}"
        return _fail(f"{words} (ENDOCAL_DEBUG=1 shows where; please report it)", FAILED)


def main() -> None:
    """Run the process's own command line and exit."""
    # Imports make a hundred thousand objects and no garbage: looking for some is a tenth of the start-up.
    gc.set_threshold(10_000)
    _fill_closed_streams()
    for name in ("SIGTERM", "SIGHUP"):
        # As an exception, so that temporary files go; not where the caller wants the signal ignored (nohup).
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) is signal.SIG_DFL:
            signal.signal(number, _terminate)
    if not sys.warnoptions and not _debugging():
        warnings.simplefilter("ignore")
        # Read when OpenCV is loaded, which is later: what it would say of a bad file, our one line says.
        os.environ.setdefault("OPENCV_LOG_LEVEL", "SILENT")
    _leave(run(sys.argv[1:]))


def _root(
    version: bool = typer.Option(False, "--version", help="Print the version and exit."),
) -> None:
    """Calibrate a wide-angle zoom lens from one picture and correct its video."""
    if version:
        from .._version import __version__

        typer.echo(f"endocal {__version__}")
        raise typer.Exit


def _add(app: typer.Typer, panel: str, name: str) -> None:
    module = importlib.import_module(f".{name}", __package__)
    examples = _examples(getattr(module, "EXAMPLES", ()))
    if hasattr(module, "group"):
        for command in module.group.registered_commands:
            own = f"endocal {name} {command.name} "
            command.epilog = _examples([e for e in module.EXAMPLES if f"{e} ".startswith(own)])
        app.add_typer(module.group, name=name, rich_help_panel=panel, epilog=examples)
    else:
        app.command(name, rich_help_panel=panel, epilog=examples)(module.command)


def _examples(lines: Sequence[str]) -> str | None:
    return "\n\n".join(["Examples:", *lines]) if lines else None


def _invoke(args: Sequence[str]) -> int:
    """Parse and run; wrong usage comes back as UsageError, everything else as it was raised."""
    if not args and _COMPLETION not in os.environ:
        with contextlib.redirect_stdout(sys.stderr):
            _invoke(["--help"])
        return WRONG_USAGE
    known = [name for commands in COMMANDS.values() for name in commands]
    # Only the command that is asked for is imported; help and completion need all.
    wanted = args[:1] if args and args[0] in known else None
    command = typer.main.get_command(build(wanted))
    tidy(command)
    convert_plainly(command)
    try:
        code = command.main(args=list(args), prog_name="endocal", standalone_mode=False)
    except typer.Abort:
        raise KeyboardInterrupt from None
    except SystemExit as exit_:
        # typer turns a broken pipe into a bare exit 1, and so does rich, which has let go of stdout then.
        if not isinstance(exit_.__context__, BrokenPipeError):
            raise
        if _raised_in(exit_) == "rich.console":
            return _end_quietly()
        raise exit_.__context__ from None
    except Exception as error:
        message: Callable[[], str] | None = getattr(error, "format_message", None)
        if message is None:
            raise
        return _report_usage(error, message())
    if code == INTERRUPTED:
        raise KeyboardInterrupt
    return code if isinstance(code, int) else DONE


def _report_usage(error: Any, message: str) -> int:
    if type(error).__name__ == "NoArgsIsHelpError":
        print(message, file=sys.stderr)
        return WRONG_USAGE
    context = getattr(error, "ctx", None)
    path = context.command_path if context is not None else "endocal"
    # One line, also where a list of choices came on several.
    print(f"{path}: {' '.join(message.split())}", file=sys.stderr)
    print(f"See '{path} --help'.", file=sys.stderr)
    return WRONG_USAGE


def _fail(message: str, code: int) -> int:
    if _debugging():
        traceback.print_exc()
    line = " ".join(message.splitlines())
    print(f"endocal: {line}", file=sys.stderr)
    return code


def _describe(error: OSError) -> str:
    reason = error.strerror or str(error) or type(error).__name__
    return f"{error.filename}: {reason}" if error.filename else reason


def _describe_output(error: OSError) -> str:
    if error.errno == errno.EBADF:
        return "standard output: is closed: send it to a file or a pipe"
    return f"standard output: {_describe(error)}: make room, or send it elsewhere"


def _debugging() -> bool:
    return bool(os.environ.get("ENDOCAL_DEBUG"))


def _fill_closed_streams() -> None:
    """Put something in the place of standard streams that the caller has closed.

    Else the next file opened would get their number, and what is printed. Standard input is empty then,
    standard output cannot be written, and standard error is forgotten.
    """
    for name, flags in (("stdin", os.O_RDONLY), ("stdout", os.O_RDONLY), ("stderr", os.O_WRONLY)):
        if getattr(sys, name) is None:
            raw = io.FileIO(os.open(os.devnull, flags), "rb" if name == "stdin" else "wb")
            # Nothing is held back to fail when the process has ended.
            setattr(sys, name, io.TextIOWrapper(raw, encoding="utf-8", write_through=True))


def _leave(code: int) -> NoReturn:
    """End the process at once where nothing is left to do, instead of taking it apart piece by piece."""
    if threading.active_count() == 1 and "multiprocessing" not in sys.modules:
        atexit._run_exitfuncs()
        with contextlib.suppress(OSError, ValueError):
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(code)
    sys.exit(code)


def _terminate(number: int, frame: object) -> None:
    sys.exit(128 + number)


def _stdout_is_closed() -> bool:
    """Say whether the reader of our standard output has gone (and not that of some other pipe)."""
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        return True
    except (OSError, ValueError):
        return False
    try:
        import select

        poll = select.poll()
        poll.register(sys.stdout.fileno(), 0)
        return any(event & select.POLLERR for _, event in poll.poll(0))
    except (AttributeError, OSError, ValueError):
        return False


def _stdout_refuses() -> bool:
    """Say whether our standard output takes nothing: neither what is held back nor a write of no bytes."""
    try:
        sys.stdout.flush()
        os.write(sys.stdout.fileno(), b"")
    except (io.UnsupportedOperation, ValueError):
        return False
    except OSError:
        return True
    return False


def _raised_in(error: BaseException) -> str:
    """Return the name of the module that raised an exception."""
    trace, module = error.__traceback__, ""
    while trace is not None:
        module, trace = trace.tb_frame.f_globals.get("__name__", ""), trace.tb_next
    return module


def _end_quietly() -> int:
    """End as a pipeline's member does whose reader wants no more."""
    _forget_stdout()
    return DONE


def _forget_stdout() -> None:
    """Let what is held back for standard output go nowhere: Python's own last flush must not fail."""
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
