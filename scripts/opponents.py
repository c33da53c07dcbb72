"""Write docs/opponents.md from what `firstlap survey --json` printed.

Usage: scripts/opponents.py SURVEY.json... >docs/opponents.md   (the commands stand in the page itself)
"""

import json
import pathlib
import statistics
import sys
from typing import Any

HEAD = """# The opponents, tuned

Printed by `scripts/opponents.py` from `firstlap survey --json`: default car (friction 0.75), noise on, both
directions, without latency. A run is so many laps from a standing start; contact ends it. Laps are flying laps in
seconds, over both directions. `sure`, `brisk`, `race` and `local_arena` are this
project's own driver, `local`; the driver with a map, `global`, stands in [global_results.md](global_results.md).

Every opponent was tuned twice. For the shortest lap of `arena` (`gap_arena`, `disparity_arena`, `pid_arena`): Optuna's
TPE, multivariate, from the defaults of the field table; the mean flying lap of two seeds, where a contact costs more
than any lap and coming nearer than 0.04 m to a wall costs too; 159, 525 and 475 trials of three laps, and for `pid`
164 more of eight laps and three seeds. For most tracks driven (`gap`, `disparity`, `pid`): one lap of all of our tracks
and nine real maps in both directions, where what fails costs most, then coming nearer than 0.08 m, then time; 74, 182
and 112 trials of TPE, then for `gap` and `pid` 39 steps each of (1+1) evolution. `brisk` was found likewise, see the
head of `setups/brisk.yaml`. `local_arena` is this project's own
driver: `firstlap tune arena --from base --budget 3m` found it, beginning among others from what an earlier search had
found; like the opponents' it is made for that track, in that direction. The searches of the opponents drove seeds 1 to
3; the races here have others among them.

```sh
for setup in gap disparity pid gap_arena disparity_arena pid_arena sure brisk race local_arena; do
  firstlap survey arena --setup $setup --laps 10 --seeds 5 --both --json >arena_$setup.json
  firstlap survey all MAP.yaml... --setup $setup --laps 2 --seeds 2 --both --json >all_$setup.json
done
scripts/opponents.py arena_*.json all_*.json >docs/opponents.md
```

"""


def name_of(track: str) -> str:
    """The name that a row shows: a map's file name without its folder."""
    return pathlib.PurePath(track).stem if track.endswith(".yaml") else track


def number(value: float | None, digits: int = 2) -> str:
    """A number, or a dash where there is none."""
    return "–" if value is None else f"{value:.{digits}f}"


def arena_table(surveys: list[dict[str, Any]]) -> str:
    """Who is how fast on arena, and how surely."""
    survey = surveys[0]
    text = f"## `arena`, {survey['laps']} laps x {survey['seeds']} seeds, both directions\n\n"
    text += "| setup | driver | clean races | forward | reverse | best | median | smallest clearance |\n"
    text += "|---|---|---|---|---|---|---|---|\n"
    rows = [(survey, survey["tracks"][0]) for survey in surveys]
    for survey, row in sorted(rows, key=lambda pair: pair[1]["median"] or 1e9):
        text += f"| `{survey['setup']}` | {survey['driver']} | {row['finished']} of {row['runs']} | "
        text += f"{clean(row, 'forward')} | {clean(row, 'reverse')} | {number(row['best'])} | "
        text += f"{number(row['median'])} | {number(row['min_clearance'])} m |\n"
    return text


def clean(row: dict[str, Any], direction: str) -> str:
    """Races of one direction that were finished."""
    runs = row["runs"] // 2
    return f"{runs - sum(failure['direction'] == direction for failure in row['failures'])} of {runs}"


def ratio(survey: dict[str, Any], sure: dict[str, Any] | None) -> str:
    """Median over tracks of the median lap against that of sure, where both finish every run."""
    if sure is None:
        return "–"
    known = {row["track"]: row for row in sure["tracks"] if row["finished"] == row["runs"]}
    shared = [
        row["median"] / known[row["track"]]["median"]
        for row in survey["tracks"]
        if row["finished"] == row["runs"] and row["track"] in known
    ]
    return f"{statistics.median(shared):.3f}" if shared else "–"


def all_table(surveys: list[dict[str, Any]]) -> str:
    """Success over all tracks and maps."""
    survey = surveys[0]
    count = len(survey["tracks"])
    text = f"## {count} tracks and maps, {survey['laps']} laps x {survey['seeds']} seeds, both directions\n\n"
    text += "Lap against `sure`: the median over the tracks on which both finish every run.\n\n"
    text += "| setup | driver | races finished | tracks with every race finished | lap against `sure` |\n"
    text += "|---|---|---|---|---|\n"
    sure = next((survey for survey in surveys if survey["setup"] == "sure"), None)
    for survey in sorted(surveys, key=lambda survey: -survey["finished"]):
        whole = sum(row["finished"] == row["runs"] for row in survey["tracks"])
        text += f"| `{survey['setup']}` | {survey['driver']} | {survey['finished']} of {survey['runs']} "
        text += f"({survey['success_rate']:.0%}) | {whole} of {count} | {ratio(survey, sure)} |\n"
    return text


def track_table(surveys: list[dict[str, Any]]) -> str:
    """Each track: share finished and median lap of each setup."""
    text = "## Track by track\n\nRaces finished, and the median flying lap where there is one.\n\n"
    text += "| track | " + " | ".join(f"`{survey['setup']}`" for survey in surveys) + " |\n"
    text += "|---|" + "---|" * len(surveys) + "\n"
    for i, first in enumerate(surveys[0]["tracks"]):
        cells = []
        for survey in surveys:
            row = survey["tracks"][i]
            lap = "" if row["median"] is None else f", {row['median']:.2f} s"
            cells.append(f"{row['finished']}/{row['runs']}{lap}")
        text += f"| {name_of(first['track'])} | " + " | ".join(cells) + " |\n"
    return text


def main(files: list[str]) -> None:
    """Print the page."""
    surveys = [json.loads(pathlib.Path(file).read_text(encoding="utf-8")) for file in files]
    order = ["gap", "disparity", "pid", "gap_arena", "disparity_arena", "pid_arena", "sure", "race", "local_arena"]
    surveys.sort(key=lambda survey: order.index(survey["setup"]) if survey["setup"] in order else len(order))
    arena = [survey for survey in surveys if len(survey["tracks"]) == 1]
    everywhere = [survey for survey in surveys if len(survey["tracks"]) > 1]
    parts = [arena_table(arena)] if arena else []
    parts += [all_table(everywhere), track_table(everywhere)] if everywhere else []
    print(HEAD + "\n".join(parts), end="")


if __name__ == "__main__":
    main(sys.argv[1:])
