"""The command `firstlap` from its first moment on: Ctrl-C is quiet while the rest is still being imported.

A package of its own, because importing anything from `firstlap` imports all of its interface.
"""

import contextlib
import os
import signal
from types import FrameType
from typing import NoReturn


def leave(_number: int, _frame: FrameType | None) -> NoReturn:
    """A signal handler: one line, exit code 130, and nothing more is run."""
    with contextlib.suppress(OSError):
        os.write(2, b"error: interrupted\n")
    os._exit(130)


def main() -> None:
    """Entry point of the command `firstlap`."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, leave)
    from firstlap.cli import main as run

    run()
