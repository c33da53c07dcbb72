"""The process around a command: Ctrl-C, readers that go away, terminals that know ASCII only."""

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
    """Ctrl-C, in a form that the option parser passes on."""


class OutputGoneError(Exception):
    """Whoever read our output has gone; in a form that the option parser passes on."""


class Commands(typer.core.TyperGroup):
    """The commands, without the parser's own answers to Ctrl-C and to a closed pipe."""

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """As of the parser; its help says what to type by our own words alone."""
        command = super().get_command(ctx, cmd_name)
        for parameter in command.params if command else ():
            if isinstance(parameter, typer.core.TyperArgument) or getattr(parameter, "is_flag", False):
                vars(parameter)["display_type_rich"] = _no_type
        return command

    def make_context(self, *arguments: Any, **options: Any) -> Any:
        """As of the parser; may print (--help, --version)."""
        with _passed_on():
            return super().make_context(*arguments, **options)

    def invoke(self, ctx: Any) -> Any:
        """Runs the chosen command."""
        with _passed_on():
            return super().invoke(ctx)


def _no_type(ctx: Any) -> None:
    """Of an argument that has a name and of a switch: <str>, <list[str]> or <bool> tell nobody more."""
    del ctx


@contextlib.contextmanager
def _passed_on() -> Iterator[None]:
    try:
        yield
    except KeyboardInterrupt:
        raise InterruptedCommandError from None
    except BrokenPipeError:
        raise OutputGoneError from None
    except SystemExit as stop:  # rich's own answer to a closed pipe
        if isinstance(stop.__context__, BrokenPipeError):
            raise OutputGoneError from None
        raise


class _Interrupts:
    """Whether Ctrl-C came. An import that it hits may turn it into another error, or swallow it."""

    seen = False


def interrupted() -> bool:
    """Whether Ctrl-C came since `watch_process`."""
    return _Interrupts.seen


def watch_process() -> None:
    """For the command line's own process: Ctrl-C raises KeyboardInterrupt, a second one leaves at once."""
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
    """An interrupt that fell into a place that cannot raise, such as a destructor, is not lost."""
    if _Interrupts.seen and issubclass(found.exc_type, KeyboardInterrupt):
        leave(signal.SIGINT, None)
    sys.__unraisablehook__(found)


def end_process(code: int) -> NoReturn:
    """Exits; from here on Ctrl-C comes too late to change anything."""
    if signal.getsignal(signal.SIGINT) in (leave, _interrupt):
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    sys.exit(code)


def _readable(error: UnicodeError) -> tuple[str, int]:
    """What the terminal's encoding lacks, in ASCII."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    text = error.object[error.start : error.end]
    return "".join(_ascii(character) for character in text), error.end


def _ascii(character: str) -> str:
    decomposed = unicodedata.normalize("NFKD", character).encode("ascii", "ignore").decode()
    return PLAIN.get(character) or decomposed or "?"


@contextlib.contextmanager
def said_or_not() -> Iterator[None]:
    """For what is said on stderr beside the result: where nobody takes it, that changes nothing."""
    try:
        yield
    except (OSError, SystemExit):  # SystemExit: rich's own answer to a closed pipe
        silence(sys.stderr)


def silence(stream: Any) -> None:
    """What is still to be flushed to a stream that cannot take it goes nowhere."""
    with contextlib.suppress(OSError, ValueError):
        descriptor = os.open(os.devnull, os.O_WRONLY)
        os.dup2(descriptor, stream.fileno())
        os.close(descriptor)
