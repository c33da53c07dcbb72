"""Process handling of the command line: Ctrl-C, closed pipes, ASCII-only terminals."""

from __future__ import annotations

import codecs
import contextlib
import io
import os
import signal
import sys
import unicodedata
from collections.abc import Iterator
from types import FrameType
from typing import Any, NoReturn

import typer.core

from firstlap.common.interrupt import leave

PLAIN = {"µ": "u", "μ": "mu", "°": "deg", "×": "x", "–": "-", "—": "-", "−": "-", "→": "->", "±": "+-", "·": "."}


class InterruptedCommandError(Exception):
    """Ctrl-C, as an exception that the option parser does not catch."""


class OutputClosedError(Exception):
    """The reader of our output has closed it; as an exception that the option parser does not catch."""


class Commands(typer.core.TyperGroup):
    """The commands, without the parser's own handling of Ctrl-C and of a closed pipe."""

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Like the parser's, but its help does not print types of arguments and flags."""
        command = super().get_command(ctx, cmd_name)
        for parameter in command.params if command else ():
            if isinstance(parameter, typer.core.TyperArgument) or getattr(parameter, "is_flag", False):
                vars(parameter)["display_type_rich"] = _no_type
        return command

    def make_context(self, *arguments: Any, **options: Any) -> Any:
        """Like the parser's; may print (--help, --version)."""
        with _uncaught():
            return super().make_context(*arguments, **options)

    def invoke(self, ctx: Any) -> Any:
        """Runs the chosen command."""
        with _uncaught():
            return super().invoke(ctx)


def _no_type(ctx: Any) -> None:
    """Hides <str>, <list[str]> and <bool>, which add nothing to a metavar or a flag."""
    del ctx


@contextlib.contextmanager
def _uncaught() -> Iterator[None]:
    try:
        yield
    except KeyboardInterrupt:
        raise InterruptedCommandError from None
    except BrokenPipeError:
        raise OutputClosedError from None
    except SystemExit as stop:  # rich exits on a closed pipe
        if isinstance(stop.__context__, BrokenPipeError):
            raise OutputClosedError from None
        raise


class _Interrupts:
    """Whether Ctrl-C was pressed. An import that it interrupts may raise another error or swallow it."""

    seen = False


def interrupted() -> bool:
    """Whether Ctrl-C was pressed since `watch_process`."""
    return _Interrupts.seen


def watch_process() -> None:
    """Installs the handlers of the command-line process: Ctrl-C raises KeyboardInterrupt, a second one exits
    immediately."""
    codecs.register_error("readable", _readable)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="readable")
    sys.unraisablehook = _unraisable
    if signal.getsignal(signal.SIGINT) in (leave, signal.default_int_handler):
        signal.signal(signal.SIGINT, _interrupt)


def _interrupt(_number: int, _frame: FrameType | None) -> NoReturn:
    _Interrupts.seen = True
    signal.signal(signal.SIGINT, leave)
    raise KeyboardInterrupt


def _unraisable(found: Any) -> None:
    """Handles an interrupt that hit code that cannot raise, such as a destructor."""
    if _Interrupts.seen and issubclass(found.exc_type, KeyboardInterrupt):
        leave(signal.SIGINT, None)
    sys.__unraisablehook__(found)


def end_process(code: int) -> NoReturn:
    """Exits; ignores Ctrl-C from here on."""
    if signal.getsignal(signal.SIGINT) in (leave, _interrupt):
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    sys.exit(code)


def _readable(error: UnicodeError) -> tuple[str, int]:
    """Replaces characters that the terminal cannot encode with ASCII."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    text = error.object[error.start : error.end]
    return "".join(_ascii(character) for character in text), error.end


def _ascii(character: str) -> str:
    decomposed = unicodedata.normalize("NFKD", character).encode("ascii", "ignore").decode()
    return PLAIN.get(character) or decomposed or "?"


@contextlib.contextmanager
def best_effort_stderr() -> Iterator[None]:
    """Ignores a failure to write remarks to stderr: it must not change the result."""
    try:
        yield
    except (OSError, SystemExit):  # SystemExit: rich exits on a closed pipe
        silence(sys.stderr)


def silence(stream: Any) -> None:
    """Discards what is still to be flushed to a stream that cannot be written."""
    with contextlib.suppress(OSError, ValueError):
        descriptor = os.open(os.devnull, os.O_WRONLY)
        os.dup2(descriptor, stream.fileno())
        os.close(descriptor)
