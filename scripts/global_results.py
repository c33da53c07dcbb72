"""Write docs/global_results.md from what `scripts/everywhere.py` printed.

Usage: scripts/global_results.py FOUND.json >docs/global_results.md   (the command stands in the page itself)
"""

import json
import pathlib
import sys
from typing import Any

HEAD = """# The map-based driver everywhere

Printed by `scripts/global_results.py` from

```sh
scripts/everywhere.py all MAP.yaml... --latency {latency} --laps {laps} --seeds {seeds}{both} >found.json
```

Default car (friction 0.75), noise on, {laps} laps from a standing start, {seeds} seeds, {directions}; every command
comes {delay} after its scan. The map is made from a slow lap, the line on that map, and the car knows its place only
from scans and noisy odometry. **{finished} of {runs} races were driven to their end without contact.**

| track | finished | best | median | clearance | a step: p50, p99 |
|---|---|---|---|---|---|
"""


def row(found: dict[str, Any]) -> str:
    """One line of the table."""
    track = pathlib.PurePath(found["track"])
    laps = [f"{found[name]:.2f}" if found[name] else "–" for name in ("best", "median")]
    p50, p99 = (f"{0.001 * found['compute'][name]:.1f}" for name in ("p50", "p99"))
    return (
        f"| {track.stem if track.suffix == '.yaml' else track} | {found['finished']} of {found['runs']} | {laps[0]} | "
        f"{laps[1]} | {found['min_clearance']:.2f} m | {p50}, {p99} ms |"
    )


def main() -> None:
    """Prints the page."""
    found = json.loads(pathlib.Path(sys.argv[1]).read_text())
    delay = found["latency"].removeprefix("fixed:") + " ms" if found["latency"].startswith("fixed:") else "as it took"
    both = found["both"]
    words = {"both": " --both" if both else "", "directions": "both directions" if both else "forward", "delay": delay}
    print(HEAD.format(**{**found, **words}) + "\n".join(row(one) for one in found["tracks"]))
    print(
        "\nLaps in seconds, without the first. A step is localisation, control and the guard together, in processor\n"
        "time: the median over the races of each race's percentiles."
    )


if __name__ == "__main__":
    main()
