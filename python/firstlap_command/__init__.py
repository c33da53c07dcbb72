"""The command `firstlap` from its first moment on: Ctrl-C is quiet while the rest is still being imported.

It imports next to nothing, because until its handler stands Ctrl-C is answered by the interpreter.
"""

from __future__ import annotations

import os
import signal
import sys

from firstlap.common.interrupt import leave


def open_standard_streams() -> None:
    """Where the caller closed stdin, stdout or stderr (`2>&-`), nothing reads or writes there from now on.

    Otherwise the next file that is opened would get its number, and what is said there would land in that file.
    """
    for number, name, mode in ((0, "stdin", "r"), (1, "stdout", "w"), (2, "stderr", "w")):
        if getattr(sys, name) is not None:
            continue
        descriptor = os.open(os.devnull, os.O_RDWR)
        if descriptor != number:
            os.dup2(descriptor, number)
            os.close(descriptor)
        setattr(sys, name, open(number, mode, closefd=False))  # noqa: SIM115


def main() -> None:
    """Entry point of the command `firstlap`."""
    open_standard_streams()
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, leave)
    from firstlap.cli import main as run

    run()
