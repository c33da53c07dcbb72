"""Write docs/results.md from what `firstlap survey --json` printed.

Usage: scripts/results.py SURVEY.json... [--elsewhere SURVEY.json...] >docs/results.md   (commands: in the page)
"""

import argparse
import json
import pathlib
import statistics
from typing import Any

HEAD = """# What was driven

Printed by `scripts/results.py` from `firstlap survey --json`, noise on, both directions, default car (friction 0.75)
unless another is named. A run is `laps` laps from a standing start; contact ends it. Laps are flying laps in seconds,
over both directions.

```sh
firstlap survey all MAP.yaml... --setup sure --laps 10 --seeds 10 --both --json >sure.json
firstlap survey all MAP.yaml... --setup brisk --laps 10 --seeds 10 --both --json >brisk.json
firstlap survey all MAP.yaml... --setup base --laps 3 --seeds 5 --both --json >base.json
firstlap survey all MAP.yaml... --setup race --laps 3 --seeds 5 --both --json >race.json
for setup in sure brisk; do
  few="--setup $setup --laps 3 --seeds 1 --both --json"
  firstlap survey random:1-200 $few >${setup}_random.json
  firstlap survey all MAP.yaml... $few --option mu_scale=0.85 >${setup}_friction.json
  firstlap survey all MAP.yaml... $few --option delay_extra=0.02 >${setup}_delay.json
  firstlap survey all MAP.yaml... $few --car nuc2 >${setup}_nuc2.json
  firstlap survey all MAP.yaml... $few --car gym >${setup}_gym.json
  firstlap survey ELSEWHERE.yaml... --setup $setup --laps 3 --seeds 3 --both --json >elsewhere_$setup.json
done
scripts/results.py sure.json brisk.json base.json race.json sure_*.json brisk_*.json \\
  --elsewhere elsewhere_sure.json elsewhere_brisk.json >docs/results.md
```

"""

ELSEWHERE = """## Maps that nothing here was made on

Every closed track in the maps of four public repositories, each once (`HiPeRT/unimore_roboracer`, with the tracks of
`f1tenth/f1tenth_racetracks` in it, `F1Tenth-INI/f1tenth_development_gym`, `ForzaETH/race_stack`,
`BDEvan5/f1tenth_benchmarks`) that is not among the nine above. They were first driven when the planner was finished;
one of its rules, on tracks wider than `width_max`, came of what `vegas` showed. What fails: `JFR_racingv5` and
`datacenter` bend more sharply than the car turns, in lanes of less than a metre; in `RCA1` a pocket beside the way on
looks like it, and a car without a reverse gear does not come out again; `london3` has a fork, and the planner takes the
other way; `IPZ20` and `ini10` are rooms with obstacles. The path of `brisk` swings out before tight bends and drives
the first two; it reads scans as `sure` does. Its distance to the walls was chosen with these maps in sight: 0.2 m lost
`mille_conf3`, `mille_conf4` and `hangar_ini`, 0.3 m none of them.

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


def conditions(survey: dict[str, Any]) -> str:
    """What a survey changed about car and race, "" where nothing."""
    car = [f"car {survey['car']}"] if survey["car"] != "default" else []
    return ", ".join(car + [f"{name} {value:g}" for name, value in survey.get("options", {}).items()])


def under_conditions(surveys: list[dict[str, Any]]) -> str:
    """The surveys of other cars and conditions as one table: per track, runs finished and smallest clearance. Those of
    another setup than the first one's as a line each."""
    if not surveys:
        return ""
    heads = [f"`{s['setup']}`, {conditions(s)}" for s in surveys]
    text = "## Under other conditions\n\n"
    text += "Runs finished and smallest clearance. `nuc2` and `gym` are the other two cars, with the same setup.\n\n"
    for survey, head in zip(surveys, heads, strict=True):
        text += f"- {head}: {survey['finished']} of {survey['runs']} runs finished "
        text += f"({survey['laps']} laps, {survey['seeds']} seed{'s' * (survey['seeds'] > 1)}){lost(survey)}.\n"
    surveys = [survey for survey in surveys if survey["setup"] == surveys[0]["setup"]]
    heads = heads[: len(surveys)]
    found = [{name_of(row["track"]): row for row in survey["tracks_list"]} for survey in surveys]
    text += f"\n| track | {' | '.join(heads)} |\n|---{'|---' * len(heads)}|\n"
    for track in dict.fromkeys(track for rows in found for track in rows):
        cells = [cell(rows.get(track)) for rows in found]
        text += f"| {track} | {' | '.join(cells)} |\n"
    return text + "\n"


def lost(survey: dict[str, Any]) -> str:
    """Where not every run was finished, "" where all were."""
    tracks = [name_of(row["track"]) for row in survey["tracks_list"] if row["finished"] < row["runs"]]
    return f"; not all on {', '.join(tracks)}" if tracks else ""


def cell(row: dict[str, Any] | None) -> str:
    """Runs finished and smallest clearance of one track, a dash where it was not driven."""
    if row is None or row["min_clearance"] is None:
        return "–"
    return f"{row['finished']} of {row['runs']}, {row['min_clearance']:.2f} m"


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


def elsewhere(surveys: list[dict[str, Any]]) -> str:
    """Surveys of maps that are not at hand: of the first all rows, of the others what they did not finish."""
    if not surveys:
        return ""
    first, *others = surveys
    text = f"{ELSEWHERE}- {total(first)}.\n"
    for survey in others:
        text += f"- {total(survey)}{lost(survey)}.\n  Its laps are {against(survey, first):.3f} of those of "
        text += f"`{first['setup']}`, by the median over the maps on which both finish every run.\n"
    text += f"\nThe rows are of `{first['setup']}`.\n\n" if others else "\n"
    text += "| map | length | finished | median | smallest clearance | first failure |\n|---|---|---|---|---|---|\n"
    for row in first["tracks_list"]:
        clearance = "–" if row["min_clearance"] is None else f"{row['min_clearance']:.2f} m"
        text += f"| {name_of(row['track'])} | {row['track_length']:.0f} m | {row['finished']} of {row['runs']} | "
        text += f"{seconds(row['median'])} | {clearance} | {failure(row)} |\n"
    return text + "\n"


def total(survey: dict[str, Any]) -> str:
    """What a survey drove, and how much of it was finished."""
    what = f"`{survey['setup']}`, {survey['laps']} laps x {survey['seeds']} seeds, {survey['tracks']} maps"
    return f"{what}: {survey['finished']} of {survey['runs']} runs finished"


def against(survey: dict[str, Any], other: dict[str, Any]) -> float:
    """Median over the tracks, on which both finish every run, of the ratio of their median laps."""
    rows = {row["track"]: row for row in other["tracks_list"] if row["finished"] == row["runs"]}
    return statistics.median(
        row["median"] / rows[row["track"]]["median"]
        for row in survey["tracks_list"]
        if row["track"] in rows and row["finished"] == row["runs"]
    )


def failure(row: dict[str, Any]) -> str:
    """The first one of a track, "" where there is none."""
    if not row["failures"]:
        return ""
    first = row["failures"][0]
    return f"{first['outcome'].replace('_', ' ')} at {first['s']:.0f} m, {first['direction']}"


def load(file: str) -> dict[str, Any]:
    """A survey with its rows as tracks_list, and their number as tracks."""
    survey: dict[str, Any] = json.loads(pathlib.Path(file).read_text())
    survey["tracks_list"] = survey["tracks"]
    survey["tracks"] = len(survey["tracks_list"])
    return survey


def main(given: list[str] | None = None) -> None:
    """Print the page."""
    parser = argparse.ArgumentParser()
    parser.add_argument("surveys", nargs="+")
    parser.add_argument("--elsewhere", nargs="+", default=[])
    arguments = parser.parse_args(given)
    surveys = [load(file) for file in arguments.surveys]
    plain = [survey for survey in surveys if not conditions(survey)]
    changed = under_conditions([survey for survey in surveys if conditions(survey)])
    others = elsewhere([load(file) for file in arguments.elsewhere])
    print(HEAD + "\n".join([section(survey) for survey in plain] + [changed + others + ratios(plain)]), end="")


if __name__ == "__main__":
    main()
