"""The command line.

Exit codes: 0 success, 1 failed or refused, 2 bad input, 3 no driving node answers (`go`, `resume`, `stop`, `set`),
130 interrupted, 141 output pipe closed.
"""

from __future__ import annotations

import sys

import typer

from firstlap.cli import (
    ablation,
    bench,
    check,
    compare,
    drive,
    estimation,
    explain,
    latency,
    line,
    paper,
    perception,
    preflight,
    race,
    remote,
    replay,
    robustness,
    sim,
    survey,
    tracks,
    tune,
    view,
)
from firstlap.cli.common import fail
from firstlap.cli.localize import localize
from firstlap.cli.map import map_command
from firstlap.cli.process import (
    Commands,
    InterruptedCommandError,
    OutputClosedError,
    best_effort_stderr,
    end_process,
    interrupted,
    silence,
    watch_process,
)
from firstlap.cli.ros_arguments import RosCommand
from firstlap.common.errors import InputError
from firstlap.common.version import __version__

app = typer.Typer(
    cls=Commands,
    help="Race unknown tracks with a 2D LiDAR: simulate, inspect, tune.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.command("race")(race.race)
app.command("survey")(survey.survey)
app.command("compare")(compare.compare)
app.command("perception")(perception.perception)
app.command("estimation")(estimation.estimation)
app.command("robustness")(robustness.robustness)
app.command("ablation")(ablation.ablation)
app.command("tune")(tune.tune)
app.command("paper")(paper.paper)
app.command("explain")(explain.explain)
app.command("replay")(replay.replay)
app.command("check")(check.check)
app.command("tracks")(tracks.tracks)
app.command("line")(line.line)
app.command("map")(map_command)
app.command("localize")(localize)
app.command("localise", hidden=True)(localize)
app.command("bench")(bench.bench)
app.command("view", cls=RosCommand)(view.view)
app.command("drive", cls=RosCommand)(drive.drive)
app.command("go", cls=RosCommand)(remote.go)
app.command("resume", cls=RosCommand)(remote.resume)
app.command("stop", cls=RosCommand)(remote.stop)
app.command("set", cls=RosCommand)(remote.set_parameter)
app.command("preflight", cls=RosCommand)(preflight.preflight)
app.command("latency")(latency.latency)
app.command("sim", cls=RosCommand)(sim.sim)


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
    """Race unknown tracks with a 2D LiDAR: simulate, inspect, tune."""


def run(arguments: list[str] | None = None) -> int:
    """Runs one command line (default: the process's) and returns its exit code; errors are one line on stderr."""
    return _flushed(_run(sys.argv[1:] if arguments is None else arguments))


def _run(arguments: list[str]) -> int:
    try:
        code = app(arguments or ["--help"], standalone_mode=False, prog_name="firstlap")
    except InputError as error:
        return fail(str(error), 2)
    except (KeyboardInterrupt, InterruptedCommandError, typer.Abort):
        return fail("interrupted", 130)
    except (BrokenPipeError, OutputClosedError):
        silence(sys.stdout)
        return 141
    except typer.Exit as stop:
        return stop.exit_code
    except OSError as error:
        return fail(f"{error.filename or 'output'}: {error.strerror or error}", 2)
    except Exception as error:
        message = getattr(error, "format_message", None)
        if interrupted():
            return fail("interrupted", 130)
        if message is None:
            raise
        return fail(message(), 2)
    return code if isinstance(code, int) else 0


def _flushed(code: int) -> int:
    """Flushes all output and returns the exit code; 141 without a message if the reader of stdout has closed it."""
    with best_effort_stderr():
        sys.stderr.flush()
    try:
        if sys.stdout is not None:
            sys.stdout.flush()
    except BrokenPipeError:
        silence(sys.stdout)
        return 141
    except OSError as error:
        silence(sys.stdout)
        return fail(f"output: {error.strerror or error}", 2)
    return code


def main() -> None:
    """Runs the command line of this process and exits."""
    try:
        watch_process()
        code = run()
    except KeyboardInterrupt:
        code = fail("interrupted", 130)
    end_process(code)
