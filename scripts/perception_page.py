"""Write docs/perception.md from what `firstlap perception` and `firstlap replay --map` printed as JSON.

Usage: scripts/perception_page.py FOLDER >docs/perception.md   (the commands stand in the page itself)
"""

import json
import pathlib
import sys
from typing import Any

METRICS = (pathlib.Path(__file__).parents[1] / "python/firstlap/perception/metrics.py").read_text()

HEAD = """# What is perceived, and how far it is from the truth

Printed by `scripts/perception_page.py` from these commands (setup `sure`, default car, noise on, a standing lap each):

```sh
firstlap perception all MAP.yaml... --both --json >simulated.json
firstlap replay RECORDING --map MAP.yaml --json >recorded_NAME.json       # real scans with poses
firstlap replay RECORDING --json >replayed_NAME.json                      # real scans without
scripts/perception_ablation.py MAPS SCANS >ablation.json                  # with one part changed at a time
scripts/perception_page.py FOLDER >docs/perception.md
```

## What is measured

"""

TRUTH = """
Truth is computed one way for every track and map: the line of all points as far from the left walls as from the right
ones (solid walls with their joints closed), not smoothed. Left and right are the loops that walls belong to, seen in
the direction of travel: a piece of the outer wall that shows across the infield keeps the side of its loop. A
recording's direction is the car's own, scan by scan; where it turns round, left and right change.
"""


SEEN = """## What the pictures show

![the segmented slalom](perception_slalom.png)

The paper's segmented slalom on our `slalom`: the walls hide behind each other, sections 0 and 1 are the right wall, 4
and 5 the left one; the way on leads between 1 and 4.

![the width steps from 1 m to 2 m](perception_width.png)

The width steps from 1 m to 2 m within one scan (`width_step`). Beyond the step both walls are hidden for a while: the
line goes on between the two lines of sight.

![the mean of both sides is not the centerline](perception_middle.png)

In a hairpin the inner wall ends at its apex for the eye, and the mean of both sides cuts towards it; the planned line
keeps as far from the apex as from the outer wall. `make pictures` draws these three again.

Of the scans that were bad, pictures of all runs of them were looked at, and each class became a rule:

- Round the tip of an inner wall the line ran along the outer wall at half the remembered width. What is hidden is not
  nearer than the line of sight past the tip ([adr 7](adr/0007-use-the-line-of-sight-past-wall-ends.md)).
- In thinned scans a wall and what shows behind its end became one section: missing beams stretched the threshold. What
  may be a way through is a break.
- Beams lost in the wall that faces the car looked like the way on. An opening whose two edges point at each other, with
  nothing beyond, is a hole in one wall.
- After a hairpin the outer wall shows past the inner wall's end, behind the car, and was taken for the inner one. It
  keeps the side that it had, by the walls remembered and by the car's trail.
- The driver of `hangar12` turns round in the middle of the track, twice. A line that passes the car against its heading
  means that the car was turned: what was known of the sides is forgotten. All of its bad scans are of these turns.
- In the recordings the car sees itself at 118 to 135 degrees to 0.8 m: it is masked.

In the two full-density recordings (a corridor with shelves and furniture, an inside corner) the line is steady, also
where the right side is a row of shelf legs with gaps of up to a metre between. Labels change far ahead, 6 to 8 m, where
single legs stand for a wall. In the inside corner two scans in a row have no way on: the corridor ahead closes to one
wall round the car. What is left of errors in the simulated runs lies 3 m ahead and beyond, where the inner wall of a
bend is hidden and its width must be guessed.

## Parts of the method, changed one at a time

Two real recordings (`hangar12` until its driver turns round) and three simulated drives (`width_step`, `lausitzring1`
and `hangar16` in reverse); each figure is that of the worst of them; errors and jumps in mm, shares in %. The changes
are made by `--set`.
"""

ABSENT = """What cannot be switched, because the line is traced ([adr 1](adr/0001-trace-the-centerline.md)):
there is no base side whose changes hysteresis would damp; no wall sample is shifted, so that no local guard stands
against the true offset, which every row has; and where both walls are seen no width is estimated, so that a constant
one shows only where one wall is hidden.

The adaptive width matters most; the mask of the car's body and the end of a chain come next, in the labels and on real
scans; the form of the break test, the memories and elimination change little on these drives."""


def load(path: pathlib.Path) -> Any:
    """One JSON file."""
    return json.loads(path.read_text())


def name_of(track: str) -> str:
    """A map's file name without its folder."""
    return pathlib.PurePath(track).stem if track.endswith(".yaml") else track


def millimetres(error: dict[str, Any]) -> str:
    """Median / 95th percentile."""
    return "-" if error["median"] is None else f"{1000 * error['median']:.0f} / {1000 * error['p95']:.0f}"


def percent(value: float | None) -> str:
    """A share with one decimal."""
    return "-" if value is None else f"{100 * value:.1f}"


def row(name: str, found: dict[str, Any]) -> str:
    """One line of the table: all errors in mm, shares in %."""
    errors = [millimetres(found["error"][ahead]) for ahead in ("0.5", "1", "2", "3")]
    shares = [percent(found[key]) for key in ("no_line", "bad", "precision", "recall")]
    reach = [percent(found["available"][reach]) for reach in ("1", "2", "3")]
    jump = "-" if found["jump"]["p95"] is None else f"{1000 * found['jump']['p95']:.0f}"
    width = millimetres(found["width_error"]["1"])
    changes = f"{found['changes_per_metre'] or 0.0:.2f}"
    cells = [name, *errors, shares[0], shares[1], " / ".join(reach), shares[2], shares[3], width, jump, changes]
    return "| " + " | ".join(cells) + " |"


def table(rows: list[str]) -> str:
    """With its heading."""
    head = (
        "| | 0.5 m | 1 m | 2 m | 3 m | no line | bad | reaches 1 / 2 / 3 m | precision | recall "
        "| width at 1 m | jump p95 | changes /m |\n|---" + "|---:" * 12 + "|\n"
    )
    return head + "\n".join(rows) + "\n"


def simulated(found: dict[str, Any]) -> str:
    """Every track and map in both directions, and the worst of each figure."""
    rows = []
    for run in found["runs"]:
        arrow = " ↺" if run["direction"] == "reverse" else ""
        ended = "" if run["outcome"] == "finished" else f" ({run['outcome']})"
        rows.append(row(name_of(run["track"]) + arrow + ended, run))
    runs = found["runs"]
    near = ("0.5", "1", "2")
    median = max(run["error"][ahead]["median"] for run in runs for ahead in near)
    p95 = max(run["error"][ahead]["p95"] for run in runs for ahead in near)
    worst = (
        f"The worst of {len(runs)} runs: median {1000 * median:.0f} mm and 95th percentile {1000 * p95:.0f} mm up to "
        f"2 m ahead, bad {percent(max(run['bad'] for run in runs))} %, precision "
        f"{percent(min(run['precision'] for run in runs))} %, recall {percent(min(run['recall'] for run in runs))} %.\n"
    )
    return table(rows) + "\n" + worst


def replayed(names: dict[str, Any]) -> str:
    """Recordings without poses."""
    text = (
        "| | scans | reaches 1 / 2 / 3 m [%] | jump p95 [mm] | jumps above 0.15 m [%] | changes of side [%] |\n"
        "|---|---:|---:|---:|---:|---:|\n"
    )
    for name, found in names.items():
        reach = " / ".join(percent(found["available"][reach]) for reach in ("1", "2", "3"))
        jump = found["jump"]
        text += (
            f"| {name} | {found['scans']} | {reach} | {1000 * jump['p95']:.0f} | {percent(jump['big'])} "
            f"| {percent(found['changes_of_side']['share'])} |\n"
        )
    return text


def ablation(changes: list[dict[str, Any]]) -> str:
    """One line per change, each figure that of the worst recording and the worst drive."""
    text = (
        "| | real: bad | p95 at 2 m | precision | recall | jump p95 | simulated: bad | p95 at 2 m | precision | recall "
        "| jump p95 |\n|---|" + "---:|" * 10 + "\n"
    )
    for change in changes:
        cells = []
        for group in (list(change["real"].values()), list(change["simulated"].values())):
            cells += [
                percent(max(one["bad"] for one in group)),
                f"{1000 * max(one['error']['2']['p95'] or 0.0 for one in group):.0f}",
                percent(min(one["precision"] for one in group)),
                percent(min(one["recall"] for one in group)),
                f"{1000 * max(one['jump']['p95'] or 0.0 for one in group):.0f}",
            ]
        lost = sum(one["outcome"] != "finished" for one in change["simulated"].values())
        what = change["what"] + (f"<br>`{change['set']}`" if change["set"] else "")
        what += f"<br>{lost} of {len(change['simulated'])} drives not finished" if lost else ""
        text += f"| {what} | " + " | ".join(cells) + " |\n"
    return text


def main(folder: pathlib.Path) -> None:
    """Prints the page."""
    words = METRICS.split('"""')[1].split("\n", 2)[2].strip()
    print(HEAD + words)
    print(TRUTH)
    print("## Simulated scans\n\nErrors in mm, median / 95th percentile; shares in %. ↺ is the reverse direction.\n")
    print(simulated(load(folder / "simulated.json")))
    print("## Real scans with poses, against the map\n")
    recorded = {path.stem.removeprefix("recorded_"): load(path) for path in sorted(folder.glob("recorded_*.json"))}
    print(table([row(name, found["against_map"]) for name, found in recorded.items()]))
    for name, found in recorded.items():
        on_map = found["against_map"]
        print(
            f"- {name}: {on_map['scans']} scans, {on_map['metres']:.0f} m; {percent(on_map['not_judged'])} % of the "
            f"returns lie by no wall of the map; the car turned round {on_map['turns']} times."
        )
    print("\nMap and poses carry errors of their own: the walls seen lie 10 to 30 mm from the map's.\n")
    print("## Real scans without poses\n")
    print(replayed({p.stem.removeprefix("replayed_"): load(p) for p in sorted(folder.glob("replayed_*.json"))}))
    print(SEEN)
    print(ablation(load(folder / "ablation.json")))
    print(ABSENT)


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))
