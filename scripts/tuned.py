"""Write docs/tuning_results.md from what `firstlap tune --json` printed, one file for each track.

Usage: scripts/tuned.py [--global SURVEY.json]... [--note TEXT] TUNED.json... >docs/tuning_results.md

--global: what `firstlap survey --driver global --json` printed; fills the column "to global".
"""

import argparse
import json
import pathlib
import sys
from typing import Any

HEAD = """# What tuning found

Printed by `scripts/tuned.py` from `firstlap tune --json`, which `scripts/tune_maps.sh` runs for `arena` and maps. Every
race differs in seed, grip, delays, mass, servo and start as of the field table in
[parameters.md](parameters.md#tuning). Laps are mean flying laps in seconds on unseen seeds, which neither the search
nor the choice had raced; `from` is the setup that the search was to beat, on the same seeds. `chosen on`: seeds x laps
of the choice. `laps`: simulated in the search. `to global`: the tuned lap over the median lap of the driver `global`,
which knows the map. On `arena` the search began without `local_arena`, which was found by tuning on it;
nowhere did it begin with `brisk`, which is younger than these searches.

```sh
scripts/tune_maps.sh MAPS OUT --budget 3m
scripts/everywhere.py all MAP.yaml... --latency fixed:5 --laps 10 --seeds 5 >global.json
scripts/tuned.py --global global.json OUT/*.json >docs/tuning_results.md
```

"""


def name_of(track: str) -> str:
    """The name that a row shows: a map's file name without its folder."""
    return pathlib.PurePath(track).stem if track.endswith(".yaml") else track


def global_laps(paths: list[str]) -> dict[str, float]:
    """{track: median lap [s]} of the surveys."""
    laps = {}
    for path in paths:
        survey = json.loads(pathlib.Path(path).read_text(encoding="utf-8"))
        laps.update({name_of(row["track"]): row["median"] for row in survey["tracks"] if row["median"]})
    return laps


def laps_table(found: list[dict[str, Any]], laps: dict[str, float]) -> str:
    """What was gained where, and at what price."""
    lines = [
        "| track | from | lap | tuned | less | finished | clearance | chosen on | trials | laps | to global |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for one in found:
        place = one["validation"]["places"][0]
        tuned, start = place["tuned"], place["compared"]
        name = name_of(one["track"])
        cells = [
            name,
            one["compared_with"]["setup"],
            f"{start['lap']:.2f}",
            f"{tuned['lap']:.2f}",
            f"{100 * (1 - tuned['lap'] / start['lap']):.1f} %",
            f"{tuned['races'] - tuned['failed']} of {tuned['races']}",
            f"{tuned['clearance']:.2f} m",
            f"{one['judge']['check_seeds']:g} x {one['judge']['check_laps']:g}",
            f"{one['trials']}",
            f"{one['laps']:.0f}",
            f"{tuned['lap'] / laps[name]:.3f}" if name in laps else "–",
        ]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def seen_table(found: list[dict[str, Any]]) -> str:
    """The fastest seen, and how often it fails."""
    lines = ["| track | holds | fastest seen, in the search | fails on fresh seeds |", "|---|---|---|---|"]
    for one in found:
        holds, seen = one["holds"], one["seen"]
        same = seen["trial"] == holds["trial"]
        there = seen.get("lap_in_search", seen["lap"])
        lap = "the same" if same else "–" if there is None else f"{there:.2f}"
        failed, near = f"{seen['failed']} of {seen['races']}", seen["margin_broken"]
        if near > seen["failed"]:
            failed += f", nearer to a wall than the margin in {near}"
        lines.append(f"| {name_of(one['track'])} | {holds['lap']:.2f} | {lap} | {failed} |")
    return "\n".join(lines)


def elsewhere_table(found: list[dict[str, Any]]) -> str:
    """The verdict, and where the tuned setup failed more than the other."""
    lines = [
        "| track | over-tuned | where it fails more | the other direction | other tracks |",
        "|---|---|---|---|---|",
    ]
    for one in found:
        validation = one["validation"]
        other, *tracks = (place["tuned"] for place in validation["places"][1:])
        worse = ", ".join(place["name"] for place in validation["places"] if place["worse"])
        races = sum(row["races"] for row in tracks)
        finished = f"{other['races'] - other['failed']} of {other['races']}"
        elsewhere = f"{races - sum(row['failed'] for row in tracks)} of {races}"
        verdict = "yes" if validation["over_tuned"] else "no"
        lines.append(f"| {name_of(one['track'])} | {verdict} | {worse or '–'} | {finished} | {elsewhere} |")
    return "\n".join(lines)


def rules_table(found: list[dict[str, Any]]) -> str:
    """`firstlap check` of what was found."""
    names = list(dict.fromkeys(rule["name"] for one in found for rule in one["holds"]["rules"]))
    lines = ["| track | " + " | ".join(names) + " |", "|---" * (len(names) + 1) + "|"]
    for one in found:
        rules = {rule["name"]: rule for rule in one["holds"]["rules"]}
        cells = [f"{rules[n]['value']:.2f}{'' if rules[n]['holds'] else ' (!)'}" if n in rules else "–" for n in names]
        lines.append(f"| {name_of(one['track'])} | " + " | ".join(cells) + " |")
    wanted = {rule["name"]: rule["wanted"] for one in found for rule in one["holds"]["rules"]}
    lines.append("| wanted | " + " | ".join(wanted[name] for name in names) + " |")
    return "\n".join(lines)


def main() -> int:
    """Prints the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--global", dest="surveys", action="append", default=[])
    parser.add_argument("--note", default="", help="a paragraph below the first table")
    parser.add_argument("tuned", nargs="+")
    arguments = parser.parse_args()
    found = [json.loads(pathlib.Path(path).read_text(encoding="utf-8")) for path in arguments.tuned]
    found = [one for one in found if one["holds"] and one["validation"]]
    sys.stdout.write(HEAD + laps_table(found, global_laps(arguments.surveys)))
    sys.stdout.write(f"\n\n{arguments.note}" if arguments.note else "")
    sys.stdout.write("\n\n## Fastest that holds, and fastest seen\n\n" + seen_table(found))
    elsewhere = [one for one in found if len(one["validation"]["places"]) > 1]
    if elsewhere:
        sys.stdout.write("\n\n## Over-tuned?\n\nRaces finished elsewhere.\n\n" + elsewhere_table(elsewhere))
    sys.stdout.write("\n\n## Against the rules of thumb\n\nAs of `firstlap check`; (!) where a rule is broken.\n\n")
    sys.stdout.write(rules_table(found) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
