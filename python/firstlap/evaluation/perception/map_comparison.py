"""Compares the perception on a recording with known poses with a map of the track."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from firstlap.common.errors import InputError
from firstlap.config.car_file import Car
from firstlap.config.setup_file import Setup
from firstlap.drivers.racer import Racer, step_core
from firstlap.evaluation.perception.detections import Detection
from firstlap.evaluation.perception.ground_truth import LEFT, RIGHT, GroundTruth
from firstlap.evaluation.perception.metrics import Perception, to_world
from firstlap.evaluation.replay.replay import prepared
from firstlap.recordings.laser import car_of
from firstlap.recordings.recording import Recording
from firstlap.tracks.library import load_track
from firstlap.tracks.track import Track

FloatArray = npt.NDArray[np.float64]

TOLERANCE = 0.3
"""How far a real return may lie from its wall on the map [m]: range noise, the map's pixels and the pose's error."""


@dataclass
class MapComparison:
    """The perception of a recording's scans compared with the map."""

    name: str
    track: Track
    setup: Setup
    car: Car
    perception: Perception
    in_reverse: list[bool] = field(default_factory=list)
    walls: dict[int, list[FloatArray]] = field(default_factory=lambda: {LEFT: [], RIGHT: []})
    lines: list[FloatArray] = field(default_factory=list)

    def to_dict(self) -> dict[str, Any]:
        """As in `firstlap replay --map --json`."""
        return {
            "recording": self.name,
            "map": self.track.source,
            "in_reverse": round(float(np.mean(self.in_reverse)), 5) if self.in_reverse else None,
            "turns": int(np.count_nonzero(np.diff(self.in_reverse))),
            "setup": self.setup.name,
            "set": {f"{section}.{name}": value for (section, name), value in self.setup.changed.items()},
            "car": self.car.name,
            **self.perception.to_dict(),
        }

    def plot(self, path: str | Path) -> None:
        """Writes a plot of the perceived walls and planned centerlines on the map."""
        from firstlap.evaluation.perception.plot import plot_against_map

        plot_against_map(self, path)


def measure(
    recording: Recording,
    setup: Setup,
    car: Car,
    map_path: str | Path,
    *,
    mask_body: bool = True,
    on_progress: Callable[[int], object] | None = None,
    each: Callable[[Detection, tuple[float, float, float], Perception], object] | None = None,
) -> MapComparison:
    """Replays every scan of a recording with poses and compares it with the map at `map_path`.

    The direction of travel is the car's own: left and right change where it turns around. mask_body: as for `replay`.
    on_progress: called after every scan with how many are done; an exception from it ends the replay. Raises
    InputError.
    """
    poses = recording.poses
    if poses is None:
        raise InputError(f"{recording.name}: has no poses; a comparison with a map needs a recording with poses")
    track = load_track(str(map_path))
    forward = GroundTruth.of(track)
    check_on_map(recording, forward, poses, map_path)
    backward = forward.reversed()
    perception = Perception(forward, tolerance=TOLERANCE)
    car = car_of(recording, car)
    found = MapComparison(recording.name, track, setup, car, perception)
    setup, _, _ = prepared(recording, setup, mask_body)
    racer = Racer(setup, car)
    front = setup.params(car.core).values()["car"]["wheelbase"]
    for i, dt in enumerate(recording.dts.tolist()):
        step_core(racer.core, recording.scan(i), recording.state(i), dt)
        x, y, yaw = (float(v) for v in poses[i])
        seen = Detection.of(racer.trace, front)
        reverse = forward.along(x, y, yaw) < 0.0
        perception.truth = backward if reverse else forward
        found.in_reverse.append(reverse)
        perception.add(seen, (x, y, yaw), dt)
        for side in (LEFT, RIGHT):
            found.walls[side].append(to_world(seen.points[seen.side == side], (x, y, yaw)))
        found.lines.append(to_world(seen.line, (x, y, yaw)))
        if each:
            each(seen, (x, y, yaw), perception)
        if on_progress:
            on_progress(i + 1)
    return found


def check_on_map(recording: Recording, truth: GroundTruth, poses: FloatArray, map_path: str | Path) -> None:
    """Raises InputError if the poses are from another map or from odometry, for which the result would be
    meaningless."""
    if recording.frame == "odom":
        raise InputError(
            f"{recording.name}: its poses are from odometry (frame 'odom') and cannot be compared "
            f"with {map_path}; expected poses of a localizer in that map's frame, see --pose-topic"
        )
    off = np.array([np.hypot(*(truth.line - pose[:2]).T).min() for pose in poses[:: max(1, len(poses) // 200)]])
    widest = 0.5 * float(truth.width.max()) + 0.3
    if np.mean(off > widest) > 0.2:
        raise InputError(
            f"{recording.name}: its poses (frame '{recording.frame}') are not on the track of {map_path}: "
            f"{np.median(off):.1f} m from its centerline (median); expected poses in that map's frame"
        )
