"""Measure whether viewers slow the car: step times and scan timing of a shown race, with and without viewers.

Viewers are separate processes: plain clients that read every message like a browser (`clients`), clients that stop
reading like a suspended browser (`sleepers`), or pages of a real browser (`browsers`, needs playwright and chromium;
software rendering uses all available CPU time). The kinds alternate within one run, so that other load on the machine
affects all of them alike. Prints a table in Markdown: the step by its thread's CPU clock and by the wall clock, how
late scans were, and by how much the period between two scans was off, all in microseconds; and how many frames the page
was shown a second.
"""

from __future__ import annotations

import argparse
import contextlib
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from firstlap.cli.view import panels_of
from firstlap.config.car_file import load_car
from firstlap.config.setup_file import load_setup
from firstlap.pitwall.app import App, serve
from firstlap.pitwall.sim_source import SimSource
from firstlap.tracks.library import load_track

KINDS = ("clients", "sleepers", "browsers")
CHROMIUM = "/usr/bin/chromium"
ARRIVAL = 120.0
"""[s] Timeout for all viewers to connect."""
SETTLING = 2.0
"""[s] Warm-up after that, not measured."""


def main() -> None:
    """Measures and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--track", default="arena")
    parser.add_argument("--setup", default="sure")
    parser.add_argument("--viewers", type=int, default=3)
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=["clients"])
    parser.add_argument("--seconds", type=float, default=15.0, help="duration of each measurement [s]")
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--view", nargs=2, metavar=("KIND", "ADDRESS"), help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.view:
        view(*given.view, given.viewers)
        return
    source = SimSource(load_track(given.track), load_setup(given.setup), load_car("default"))
    source.start()
    try:
        app = serve(source, port=0, panel=panels_of(source))
        try:
            report(measured(source, app, given), given)
        finally:
            app.close()
    finally:
        source.close()


def measured(source: SimSource, app: App, given: argparse.Namespace) -> dict[str, list[Any]]:
    """(steps, lateness, frames a second) of every round, by who watched."""
    found: dict[str, list[Any]] = defaultdict(list)
    for _ in range(given.rounds):
        for kind in ("nobody", *given.kinds):
            with viewers(app, kind, 0 if kind == "nobody" else given.viewers):
                time.sleep(SETTLING)
                source.timing(ARRIVAL)
                time.sleep(given.seconds)
                found[kind].append((*source.timing(ARRIVAL), app.updates))
    return found


def report(found: dict[str, list[Any]], given: argparse.Namespace) -> None:
    """The table with p50 and p99."""
    columns = ("viewers", "steps", "step, CPU", "step, wall", "late", "period off", "frames/s")
    print(f"| {' | '.join(columns)} |")
    print("|---|---|---|---|---|---|---|")
    for kind, rounds in found.items():
        steps = np.vstack([steps for steps, _, _ in rounds])
        late = np.concatenate([late for _, late, _ in rounds])
        off = np.concatenate([np.abs(np.diff(late)) for _, late, _ in rounds])
        shown = np.mean([updates for _, _, updates in rounds])
        who = "0" if kind == "nobody" else f"{given.viewers} {kind}"
        cells = [_pair(values) for values in (steps[:, 0], steps[:, 1], late, off)]
        print(f"| {who} | {len(steps)} | {' | '.join(cells)} | {shown:.0f} |")


def _pair(values: Any) -> str:
    low, high = np.percentile(values, [50, 99])
    return f"{low:.0f}, {high:.0f} µs"


@contextlib.contextmanager
def viewers(app: App, kind: str, count: int) -> Iterator[None]:
    """Runs a number of viewer processes."""
    each = count if kind == "browsers" else min(count, 1)
    command = [sys.executable, __file__, "--viewers", str(each), "--view", kind, f"127.0.0.1:{app.port}"]
    processes = [subprocess.Popen(command, stdin=subprocess.PIPE) for _ in range(count // max(each, 1))]
    try:
        end = time.monotonic() + ARRIVAL
        while app.viewers < count:
            if time.monotonic() > end:
                raise TimeoutError(f"{app.viewers} of {count} {kind} came")
            time.sleep(0.05)
        yield
    finally:
        for process in processes:
            process.communicate()  # closing its input ends the process
        end = time.monotonic() + ARRIVAL
        while app.viewers and time.monotonic() < end:
            time.sleep(0.05)


def view(kind: str, address: str, count: int) -> None:
    """Main function of a viewer process; runs until its input is closed."""
    if kind == "browsers":
        _browse(f"http://{address}/", count)
    else:
        _listen(address, kind == "sleepers")


def _browse(address: str, count: int) -> None:
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox", "--use-gl=swiftshader"])
        for _ in range(count):
            page = browser.new_page(viewport={"width": 1280, "height": 800})
            page.goto(address, wait_until="commit", timeout=1e3 * ARRIVAL)
        sys.stdin.read()
        browser.close()


def _listen(address: str, sleeps: bool) -> None:
    import threading

    import msgspec
    import viser
    from websockets.sync.client import connect

    sys.path.insert(0, str(Path(__file__).parents[1] / "python" / "tests"))
    from viewing import CAMERA

    protocol: Any = f"viser-v{viser.__version__}"
    origin: Any = f"http://{address}"
    connection = connect(f"ws://{address}/", subprotocols=[protocol], origin=origin, max_size=None, compression=None)
    connection.send(msgspec.msgpack.encode(CAMERA))

    def read() -> None:
        for _ in connection:
            pass

    if not sleeps:
        threading.Thread(target=read, daemon=True).start()
    sys.stdin.read()


if __name__ == "__main__":
    main()
