"""Write docs/results.md from what `firstlap survey --json` printed.

Usage: scripts/results.py SURVEY.json... >docs/results.md   (the commands stand in the page itself)
"""

import json
import pathlib
import statistics
import sys
from typing import Any

HEAD = """# What was driven

Printed by `scripts/results.py` from `firstlap survey --json`, noise on, default car (friction 0.75), both directions.
A run is `laps` laps from a standing start; contact ends it. Laps are flying laps in seconds, over both directions.

```sh
firstlap survey all MAP.yaml... --setup sure --laps 10 --seeds 10 --both --json >sure.json
firstlap survey all MAP.yaml... --setup base --laps 3 --seeds 5 --both --json >base.json
firstlap survey all MAP.yaml... --setup race --laps 3 --seeds 5 --both --json >race.json
firstlap survey random:1-200 --setup sure --laps 3 --seeds 1 --both --json >random.json
scripts/results.py sure.json base.json race.json random.json >docs/results.md
```

"""


def name_of(track: str) -> str:
    """The name that a row shows: a map's file name without its folder."""
    return pathlib.PurePath(track).stem if track.endswith(".yaml") else track


def seconds(value: float | None) -> str:
    """A lap time, or a dash where no lap was finished."""
    return "–" if value is None else f"{value:.2f}"


def section(survey: dict[str, Any]) -> str:
    """One survey as a heading, its totals and, for few tracks, a table."""
    rows = survey["tracks_list"]
    what = f"{survey['laps']} laps x {survey['seeds']} seeds, {survey['tracks']} tracks"
    text = f"## `{survey['setup']}`, {what}\n\n{survey['finished']} of {survey['runs']} runs finished.\n\n"
    if len(rows) > 40:
        failed = [name_of(row["track"]) for row in rows if row["finished"] < row["runs"]]
        smallest = min(row["min_clearance"] for row in rows if row["min_clearance"] is not None)
        lost = ", ".join(failed) if failed else "none"
        return text + f"Tracks with a failure: {lost}. Smallest clearance: {smallest:.2f} m.\n"
    text += "| track | finished | best | median | smallest clearance |\n|---|---|---|---|---|\n"
    for row in rows:
        clearance = row["min_clearance"]
        text += f"| {name_of(row['track'])} | {row['finished']} of {row['runs']} | {seconds(row['best'])} | "
        text += f"{seconds(row['median'])} | {'–' if clearance is None else f'{clearance:.2f} m'} |\n"
    return text


def ratios(surveys: list[dict[str, Any]]) -> str:
    """Median laps against base where both finish all runs."""
    by_setup = {s["setup"]: {r["track"]: r for r in s["tracks_list"]} for s in surveys if s["tracks"] <= 40}
    if "base" not in by_setup:
        return ""
    text = "## Against `base`\n\nMedian lap over the median lap of `base`, on tracks where both finish every run.\n\n"
    text += "| setup | tracks | median ratio | smallest | largest |\n|---|---|---|---|---|\n"
    for setup, rows in by_setup.items():
        shared = [
            row["median"] / by_setup["base"][track]["median"]
            for track, row in rows.items()
            if track in by_setup["base"]
            and row["finished"] == row["runs"]
            and by_setup["base"][track]["finished"] == by_setup["base"][track]["runs"]
        ]
        if setup != "base" and shared:
            middle = statistics.median(shared)
            text += f"| `{setup}` | {len(shared)} | {middle:.3f} | {min(shared):.3f} | {max(shared):.3f} |\n"
    return text


def main(files: list[str]) -> None:
    """Print the page."""
    surveys = []
    for file in files:
        survey = json.loads(pathlib.Path(file).read_text())
        survey["tracks_list"] = survey["tracks"]
        survey["tracks"] = len(survey["tracks_list"])
        surveys.append(survey)
    print(HEAD + "\n".join([section(survey) for survey in surveys] + [ratios(surveys)]), end="")


if __name__ == "__main__":
    main(sys.argv[1:])
