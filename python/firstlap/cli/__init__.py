"""The command line. Exit codes: 0 done, 1 not finished, 2 bad input, 130 interrupted."""

from __future__ import annotations

import os
import sys

import typer

from firstlap import __version__
from firstlap.cli import bench, check, explain, perception, race, robustness, survey, tracks
from firstlap.cli.common import fail
from firstlap.errors import InputError

app = typer.Typer(
    help="Race an unseen track with a 2D LiDAR: simulate, look at every step, tune.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.command("race")(race.race)
app.command("survey")(survey.survey)
app.command("perception")(perception.perception)
app.command("robustness")(robustness.robustness)
app.command("explain")(explain.explain)
app.command("check")(check.check)
app.command("tracks")(tracks.tracks)
app.command("bench")(bench.bench)


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"firstlap {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    _version: bool = typer.Option(
        False, "--version", callback=_print_version, is_eager=True, help="Print the version."
    ),
) -> None:
    """Race an unseen track with a 2D LiDAR: simulate, look at every step, tune."""


def run(arguments: list[str] | None = None) -> int:
    """Runs one command line (default: the process's) and returns its exit code; errors are one line on stderr."""
    arguments = sys.argv[1:] if arguments is None else arguments
    try:
        code = app(arguments or ["--help"], standalone_mode=False, prog_name="firstlap")
    except InputError as error:
        return fail(str(error), 2)
    except (KeyboardInterrupt, typer.Abort):
        return fail("interrupted", 130)
    except typer.Exit as stop:
        return stop.exit_code
    except BrokenPipeError:
        # Whoever read our output has gone: nothing to say, and nothing to flush at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141
    except OSError as error:
        return fail(f"{error.filename or 'output'}: {error.strerror or error}", 2)
    except Exception as error:
        message = getattr(error, "format_message", None)
        if message is None:
            raise
        return fail(message(), 2)
    return code if isinstance(code, int) else 0


def main() -> None:
    """Entry point of the command `firstlap`."""
    sys.exit(run())
