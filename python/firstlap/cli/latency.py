"""firstlap latency"""

from __future__ import annotations

from typing import Annotated, Any

import typer

from firstlap.cli.common import (
    DriverOption,
    JsonOption,
    SetOption,
    SetupOption,
    chosen_setup,
    console,
    print_json,
    progress_bar,
)

WIDTH = 40
MIN_RATE = 5.0
"""[Hz] Rate of the slowest LiDARs."""

TrackArgument = Annotated[str, typer.Argument(metavar="TRACK", help="Track whose scans are published.")]
SecondsOption = Annotated[
    float, typer.Option("--seconds", min=1.0, max=3600.0, help="Duration of the measurement [s].")
]
RateOption = Annotated[float, typer.Option("--rate", min=MIN_RATE, max=200.0, help="Scan rate [Hz].")]


def latency(
    track: TrackArgument = "arena",
    driver: DriverOption = None,
    setup: SetupOption = None,
    changes: SetOption = None,
    seconds: SecondsOption = 20.0,
    rate: RateOption = 40.0,
    as_json: JsonOption = False,
) -> int:
    """Measure the time from scan to drive command over DDS, with a driving node in its own process."""
    from firstlap.ros import require_ros

    require_ros()
    from firstlap.ros.latency import measure

    chosen = chosen_setup(setup, changes, driver)
    with progress_bar() as bar:
        task = bar.add_task("measuring", total=1.0)
        found = measure(chosen, track, seconds, rate, lambda share: bar.update(task, completed=share))
    summary = found.summary()
    if as_json:
        print_json(summary)
    else:
        _print(chosen.title, rate, summary)
    return 0


def _print(title: str, rate: float, summary: dict[str, Any]) -> None:
    out = console()
    times, node = summary["scan_to_drive_ms"], summary["node_us"]
    answered = f"{summary['answered']} of {summary['scans']} scans answered, {summary['missed']} missed"
    answered += f", {summary['stops']} stops"
    out.print(f"{title}, {rate:g} Hz, {answered}")
    if summary["answered"]:
        out.print("scan to drive: " + ", ".join(f"{name} {value:.2f}" for name, value in times.items()) + " ms")
    own = ", ".join(f"{name} {value}" for name, value in node.items() if "[us]" in name)
    out.print(f"in the node: {own}", markup=False)
    if summary["unsent"]:
        out.print(f"{summary['unsent']} scans were not sent in time because this machine was busy")
    if summary["memory_mb"]:
        out.print(
            "memory of the node: {first:.1f} MB at the start, {last:.1f} MB at the end".format(**summary["memory_mb"])
        )
    load = summary["load"]
    out.print(f"load {load['before']:.1f} before, {load['after']:.1f} after, {load['cores']} cores")
    most = max(count for _, count in summary["histogram"]) or 1
    low = 0.0
    for edge, count in summary["histogram"]:
        if count:
            to = "more" if edge is None else f"{edge:g}"
            out.print(f"{low:6g} to {to:>4} ms {'█' * max(round(WIDTH * count / most), 1)} {count}")
        low = edge
