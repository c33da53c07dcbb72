"""Measure perception on two recordings and three simulated races with one change of the method at a time, as JSON.

Usage: scripts/perception_ablation.py MAPS SCANS >ablation.json   (folders that hold NAME/NAME.yaml and NAME/NAME.npz)
"""

import json
import pathlib
import sys
from typing import Any

from firstlap.config.car_file import load_car
from firstlap.config.setup_file import load_setup
from firstlap.evaluation.perception import map_comparison, simulated
from firstlap.recordings import load_recording
from firstlap.tracks.library import load_track

REAL = {"germany2022": None, "hangar12": 90.0}
"""Name and end time [s]: later the driver of hangar12 turns around."""
SIMULATED = (("width_step", False), ("lausitzring1", False), ("hangar16", True))
CHANGES = (
    ("reference", ""),
    ("width: constant 2 m where one wall is occluded", "width_gain=0 width_min=3 width_blend=0.1"),
    ("width memory: last scan only", "width_gain=1"),
    ("local walls: none carried over", "memory_time=0"),
    ("side consistency: off", "past_weight=0"),
    ("joints: every gap above 0.15 m is passable", "pass_ratio=0 pass_min=0.15 pass_max=0.15"),
    ("elimination: off", "min_points=1 min_chord=0 max_nearest=30"),
    ("break threshold: fixed 0.3 m", "break_min=0.3 break_max=0.3"),
    ("apex: no extra width", "apex_width=0"),
    ("chain: no end at large gaps", "chain_gap=20"),
    ("body mask: up to 0.3 m only", "mask_range=0.3"),
    ("trail: off", "trail_time=0"),
)


def main(maps: pathlib.Path, scans: pathlib.Path) -> None:
    """Prints one entry per change; progress on stderr."""
    car = load_car("default")
    recordings = {name: load_recording(scans / name / f"{name}.npz").between(None, end) for name, end in REAL.items()}
    tracks = []
    for name, reverse in SIMULATED:
        path = maps / name / f"{name}.yaml"
        track = load_track(str(path) if path.is_file() else name)
        tracks.append((name, reverse, track.reversed() if reverse else track))
    found: list[dict[str, Any]] = []
    for what, changes in CHANGES:
        print(what, file=sys.stderr, flush=True)
        setup = load_setup("sure")
        setup = setup.with_assignments(changes.split()) if changes else setup
        real = {
            name: map_comparison.measure(
                recording, setup, car, maps / name / f"{name}.yaml", mask_body=False
            ).perception.to_dict()
            for name, recording in recordings.items()
        }
        drives = {}
        for name, reverse, track in tracks:
            perception, outcome = simulated.measure(track, setup, car)
            drives[f"{name}{' reverse' if reverse else ''}"] = {"outcome": outcome, **perception.to_dict()}
        found.append({"what": what, "set": changes, "real": real, "simulated": drives})
    print(json.dumps(found, indent=1))


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]))
