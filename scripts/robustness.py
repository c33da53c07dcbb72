"""Write docs/robustness.md from what `firstlap robustness --json` printed.

Usage: scripts/robustness.py CURVES.json [OBSTACLES.json...] [--surveys SURVEY.json...] >docs/robustness.md

The commands stand in the page; --surveys are what `firstlap survey --option ... --json` printed.
"""

import json
import pathlib
import sys
from typing import Any

from firstlap.robustness import BY_NAME

HEAD = """# Robustness

Printed by `scripts/robustness.py` from `firstlap robustness --json`: one disturbance at a time, everything else as in
any race of the default car (noise 10 mm, 0.2 % of beams lost, servo delay 40 ms, friction 0.75).

```sh
{commands}
scripts/robustness.py {files} >docs/robustness.md
```

![curves](robustness.png)

"""

WHAT = """## What is disturbed

- **lost beams**: every beam of every scan is lost with this probability. **lost sectors**: the same share is lost in
  sectors of 40 beams (10°) at places that are new in every scan.
- **range noise**: standard deviation of every range. The driver's `range_sigma` stays at 10 mm.
- **pipe joints**: all walls become pipes of 1.5 m with joints of this width. The beam passes a joint, the car does not.
- **scan rate**: of the LiDAR, and with it of the commands. **latency**: from a scan's end to its command taking
  effect, on top of the servo's delay; scans are not lost by it (a *driver* that computes that long loses scans too:
  race it with `--latency fixed:MS`).
- **speed measured**: the odometry reads so much more than the car drives. **speed constant**: the car drives so much
  faster than it is told, and what it measures is wrong by the same: no wheel tells. **laser yaw**, **ahead**, **left**:
  the laser is turned or stands elsewhere than the driver believes. **range scale**: every range is so much longer than
  the way to the wall. **steering trim**, **gain**: what the wheels make of
  the angle that is commanded. Each is also an `--option` of `race`, `survey` and `robustness`
  (`--option sensors.speed_scale_error=0.1`), and so is every other field of a car.
- **obstacle**: a box of 0.33 m by 0.20 m appears on the line that the car drives without it, and 0.3 m to either side,
  at {places} places of a lap. It appears when the car has come as near as this many of its shortest stopping distances:
  two scans to see it, full braking with the grip that a bend leaves, the speed loop's tail, and 5 cm, all of the
  *simulated car*, not of the driver's own parameters (`stopping_distance` in `python/firstlap/robustness.py`). The car
  must pass or stop; a car that was already nearer than that is counted as impossible and is in no rate: nothing could
  have stopped it, though it may have swerved.

A run is contact-free when neither wall nor box was touched. Laps are median laps over those at the first value.

"""


WHY = """## Where it breaks, and why

- **Joints** are the one curve that falls. A gap narrower than 0.45 of the track's width, never less than 0.5 m, is no
  way on (`pass_ratio`, `pass_min`); a wider one may be. On a road of 1 m that limit is 0.5 m, on one of 1.8 m it is
  0.8 m. Beyond it a joint of a wall and the mouth of a corridor look the same in one scan, and where the wall bends
  away just there the car turns into the joint, touches, or stands before it and does not finish.
- **Latency** costs time first and room last. The heading loop of `sure` crosses over at 5 rad/s (`schedule_omega`);
  with 80 ms and more, on top of servo and its delay, the car weaves, the path that starts at the car and joins the
  centerline bends with it, and the profile slows down for the bends. A road of 1 m leaves no room for the weaving:
  there 100 ms ends at a wall, and the last stop (below), which counts on 50 ms from command to brakes, comes too
  late.
- **Lost beams, sectors, noise, scan rate** cost a hundredth of the lap in the median of the tracks: break and merge
  thresholds follow the spacing of the beams that are left, and walls out of sight are remembered for 0.8 s. At 10 Hz
  the car drives half a metre between scans; what it plans on are walls that do not move.
- **Wrong speeds** of up to 20 %, either way, bring no contact, though a car that is slower than told stays slow: the
  walls tell how fast they go by (`speed_scale`), and what the car makes of its commands tells whether those are wrong
  as well. A clear error is corrected within a second; what may be chance, up to about 3 %, is left alone, so that a car
  whose speed is right drives the same bits as without. Straight walls without an end in sight tell nothing; there the
  last estimate stands.
- **The obstacle**: before each command the car checks that it could still stop if it did what the command says until
  the next scan and braked fully from then on, with its body, the servo's lag, the lock and the grip (`last_stop`); if
  not, it brakes fully now. That is why it does not hit. It stops rather than passes where less than the car's width
  and 5 cm is left, or where the way round is sharper than its lock from where it came to stand: it cannot reverse.
  After a swerve at the limit it may have lost the way, and drives back (neither passed nor stopped).
- What no check can help: with less than the shortest stop (impossible, above), and `race` at exactly one stopping
  distance: its v_min of 2.75 m/s asks tight bends for grip that full braking then lacks.
"""


def name_of(track: str) -> str:
    """The name that a row shows: a map's file name without its folder."""
    return pathlib.PurePath(track).stem if track.endswith(".yaml") else track


def command(found: dict[str, Any], file: str) -> str:
    """The command line that printed `found`."""
    tracks = " ".join(f"{name_of(t)}.yaml" if t.endswith(".yaml") else t for t in found["sweeps"][0]["tracks"])
    chosen = [sweep["name"] for sweep in found["sweeps"]]
    sweeps = "" if chosen == list(BY_NAME) else "".join(f" --sweep {name}" for name in chosen)
    both = " --both" if found["both"] else ""
    runs = f"--laps {found['laps']} --seeds {found['seeds']} --places {found['places']}"
    return f"firstlap robustness {tracks} --setup {found['setup']}{sweeps} {runs}{both} --json >{file}"


def percent(rate: float | None) -> str:
    """A rate, or a dash."""
    return "–" if rate is None else f"{100.0 * rate:.1f} %"


def curve(sweep: dict[str, Any]) -> str:
    """One sweep as a table."""
    box = sweep["name"] == "obstacle"
    more = "passed | stopped | impossible" if box else "lap"
    text = f"### {sweep['title']}\n\n| {sweep['unit'] or 'times'} | runs | contact-free | finished | {more} |\n"
    text += "|---" * (7 if box else 5) + "|\n"
    for point in sweep["points"]:
        row = [f"{point['value']:g}", str(point["runs"]), percent(point["contact_free"]), percent(point["finished"])]
        if box:
            row += [percent(point["passed"]), percent(point["stopped"]), str(point["impossible"])]
        else:
            row += ["–" if point["lap_ratio"] is None else f"{point['lap_ratio']:.3f}"]
        text += "| " + " | ".join(row) + " |\n"
    return text + "\n" + contacts(sweep)


def contacts(sweep: dict[str, Any]) -> str:
    """Where something was touched or a race was not finished, track by track."""
    if not sweep["contacts"] and all(point["finished"] in (1.0, None) for point in sweep["points"]):
        return "Nothing was touched, and every run came to its end.\n\n"
    rows = {}
    for spec, points in sweep["tracks"].items():
        bad = [
            f"{point['value']:g}: {percent(point['contact_free'])} contact-free, {percent(point['finished'])} finished"
            for point in points
            if point["runs"] and point["finished"] < 1.0
        ]
        if bad:
            rows[name_of(spec)] = "; ".join(bad)
    return "\n".join(f"- {name}: {text}" for name, text in rows.items()) + "\n\n"


def survey_row(found: dict[str, Any]) -> str:
    """One survey as a row: conditions, setup, what its races came to."""
    ended = [failure["outcome"] for track in found["tracks"] for failure in track["failures"]]
    conditions = ", ".join(f"`{name}={value:g}`" for name, value in found["options"].items()) or "none"
    others = sorted(set(ended) - {"contact"})
    rest = ", ".join(f"{ended.count(outcome)} {outcome.replace('_', ' ')}" for outcome in others) or "0"
    first, last = (found["tracks"][i]["track"].removeprefix("random:") for i in (0, -1))
    tracks = f"random:{first}-{last}, {found['seeds']}"
    return f"| {conditions} | `{found['setup']}` | {tracks} | {found['runs']} | {ended.count('contact')} | {rest} |"


def surveys(found: list[dict[str, Any]]) -> str:
    """Many races on tracks that no parameter was chosen on, under wrong speeds."""
    both = " --both" if found[0]["both"] else ""
    text = "## Wrong speeds on random tracks\n\n```sh\n"
    text += f"firstlap survey TRACKS --laps {found[0]['laps']} --seeds SEEDS{both} --setup SETUP --option CONDITION\n"
    text += "```\n\n"
    text += "| condition | setup | tracks, seeds | races | contacts | other |\n|---|---|---|---|---|---|\n"
    return text + "\n".join(survey_row(one) for one in found) + "\n\n"


def page(found: list[dict[str, Any]], files: list[str], driven: list[dict[str, Any]]) -> str:
    """The whole page."""
    commands = "\n".join(command(data, file) for data, file in zip(found, files, strict=True))
    commands = commands.replace(" --json", " --json --plot docs/robustness.png", 1)
    text = HEAD.format(commands=commands, files=" ".join(files)) + WHAT.format(places=found[0]["places"])
    for data in found:
        tracks = ", ".join(name_of(track) for track in data["sweeps"][0]["tracks"])
        both = ", both directions" if data["both"] else ""
        text += f"## `{data['setup']}`: {tracks}\n\n{data['laps']} laps, seeds 1 to {data['seeds']}{both}.\n\n"
        text += "".join(curve(sweep) for sweep in data["sweeps"])
    return text + (surveys(driven) if driven else "") + WHY


def main(files: list[str]) -> None:
    """Print the page."""
    split = files.index("--surveys") if "--surveys" in files else len(files)
    found, driven = (
        [json.loads(pathlib.Path(file).read_text(encoding="utf-8")) for file in some]
        for some in (files[:split], files[split + 1 :])
    )
    print(page(found, [pathlib.PurePath(file).name for file in files[:split]], driven), end="")


if __name__ == "__main__":
    main(sys.argv[1:])
