"""A recording as a source of frames: plays, seeks, and recomputes the step when a parameter changes."""

from __future__ import annotations

import math
import threading
from collections.abc import Mapping
from pathlib import Path
from time import monotonic, thread_time_ns
from typing import Any

import numpy as np

from firstlap import _core
from firstlap.common.errors import InputError
from firstlap.config.car_file import Car
from firstlap.config.driver_kind import driver_kind
from firstlap.config.parameters import Value
from firstlap.config.setup_file import Setup
from firstlap.drivers.driving import Driving
from firstlap.evaluation.replay.replay import prepared
from firstlap.pitwall.conditions import checked_pace
from firstlap.pitwall.frame import DrivenLap, Frame, Pose, Scenery
from firstlap.pitwall.lap_setup import changed_from
from firstlap.pitwall.laps import LapBook
from firstlap.pitwall.sim_source import scenery_of
from firstlap.pitwall.source_state import SourceState
from firstlap.recordings.laser import car_of
from firstlap.recordings.recording import Recording
from firstlap.tracks.track import Track

MEMORY = 2.0
"""[s] Replayed before a scan after a jump, to restore the driver's memory."""
MAX_SCANS = 100
"""Maximum number of scans replayed for that."""
MIN_FRAME_PERIOD = 0.02
"""[s] Minimum period of frames while playing."""
LONGEST_WAIT = 1.0
"""[s] Longer gaps of the recording are shortened to this."""
MAX_LAG = 0.1
"""[s] Lag behind the recording's clock after which the lost time is skipped."""


class Planner:
    """Runs one setup on a recording. trace, step_us: of the scan `at`."""

    def __init__(self, recording: Recording, setup: Setup, car: Car) -> None:
        """Raises InputError."""
        self.recording = recording
        self.driving = Driving(setup, car)
        self.at = -1
        self.trace: Mapping[str, Any] = {}
        self.step_us = 0.0
        self._known = False

    def take(self, setup: Setup) -> None:
        """Changes to another setup of the same driver; its memory is recomputed. Raises InputError."""
        self.driving.take(setup)
        self._known = False

    def show(self, scan: int) -> None:
        """Steps to the scan: from the previous one, or after replaying the scans before it."""
        if self._known and self.at == scan:
            return
        if not self._known or self.at != scan - 1:
            self._remember(scan)
        self._step(scan)
        self.at, self._known = scan, True

    def traced(self) -> Mapping[str, Any]:
        """Updates and returns the trace of the last step."""
        self.trace = self.driving.handle.trace
        return self.trace

    def _remember(self, scan: int) -> None:
        self.driving.reset()
        part = slice(begin_of_memory(self.recording, scan), scan)
        scans = self.recording.ranges[part]
        if len(scans) == 0:
            return
        _core.replay(
            self.driving.handle.core,
            np.concatenate(scans),
            np.array([len(one) for one in scans], dtype=np.int64),
            np.ascontiguousarray(self.recording.headers[part]),
            np.ascontiguousarray(self.recording.states[part]),
            np.ascontiguousarray(self.recording.dts[part]),
        )

    def _step(self, scan: int) -> None:
        recording = self.recording
        speed, yaw_rate, steering_angle = recording.states[scan].tolist()
        seen = recording.scan(scan)
        begin = thread_time_ns()
        self.driving.step(seen, speed, yaw_rate, steering_angle, float(recording.dts[scan]))
        self.step_us = 1e-3 * (thread_time_ns() - begin)


def begin_of_memory(recording: Recording, scan: int) -> int:
    """The first scan to replay for showing `scan`."""
    return max(scan - MAX_SCANS, int(np.searchsorted(recording.stamps, recording.stamps[scan] - MEMORY)))


class RecordingSource(SourceState):
    """A `Source` that `Plays`. setup: as given; values of the car from the recording are added. track: of the
    recording's map, if known. Raises InputError."""

    def __init__(
        self,
        recording: Recording,
        setup: Setup,
        car: Car,
        *,
        track: Track | None = None,
        mask_body: bool = True,
        pace: float = 1.0,
    ) -> None:
        if not len(recording):
            raise InputError(f"{recording.name}: has no scans")
        self.recording, self.car, self.track = recording, car_of(recording, car), track
        self.title = recording.name
        self.scans = len(recording)
        self.scenery = Scenery() if track is None else scenery_of(track)
        self._mask_body = mask_body
        super().__init__(self._prepared(setup))
        self._planner = Planner(recording, self._setup, self.car)
        self._before: Planner | None = None
        self._laps = laps_of(recording)
        self._pace = checked_pace(pace)
        self._changed = threading.Condition()
        self._scan, self._wanted, self._stale = 0, 0, True
        self._playing = self._closed = False
        self._due = 0.0
        self._shown = -math.inf
        self._framed_scan = -1
        self._message = ""
        self._thread: threading.Thread | None = None

    def _prepared(self, setup: Setup) -> Setup:
        kind = driver_kind(setup.driver)
        if kind.needs_map:
            raise InputError(
                f"driver {kind.name}: needs a map of the track before it drives, which a recording does not have"
            )
        setup, _, _ = prepared(self.recording, setup, self._mask_body)
        return self._checked(setup)

    def _checked(self, setup: Setup) -> Setup:
        setup.validate(f"{setup.title} on car {self.car.name}", self.car.core)
        return setup

    # Source.

    def start(self) -> None:
        """Starts playing, in a thread."""
        with self._changed:
            if self._thread is None and not self._closed:
                self._thread = threading.Thread(target=self._run, name="recording", daemon=True)
                self._playing = True
                self._due = monotonic()
                self._thread.start()

    def close(self) -> None:
        """Ends the thread."""
        with self._changed:
            self._closed = True
            self._changed.notify()
        if self._thread is not None:
            self._thread.join()

    def change(self, values: Mapping[str, Value]) -> None:
        """Changes parameters by section.name; the shown scan is recomputed."""
        with self._changed:
            self._setup = self._checked(changed_from(self._setup.with_values(values), self._loaded))
            self._stale = True
            self._changed.notify()

    def choose(self, setup: Setup) -> None:
        """Loads another setup, possibly of another driver."""
        with self._changed:
            self._setup = self._loaded = self._prepared(setup)
            self._stale = True
            self._changed.notify()

    # Plays.

    @property
    def scan(self) -> int:
        """The number of the current scan, from 0."""
        return self._wanted

    @property
    def playing(self) -> bool:
        """Whether it is playing."""
        return self._playing

    def play(self) -> None:
        """Plays; from the start if it is at the end."""
        with self._changed:
            if self._wanted == self.scans - 1:
                self._wanted = 0
            self._playing = True
            self._due = monotonic()
            self._changed.notify()

    def pause(self) -> None:
        """Pauses."""
        with self._changed:
            self._playing = False
            self._changed.notify()

    def seek(self, scan: int) -> None:
        """Jumps to a scan, clamped to the valid range."""
        with self._changed:
            self._wanted = min(max(int(scan), 0), self.scans - 1)
            self._due = monotonic()
            self._changed.notify()

    @property
    def pace(self) -> float:
        """Playback speed, as a multiple of real time."""
        return self._pace

    def set_pace(self, pace: float) -> None:
        """Sets the playback speed, as a multiple of real time. Raises InputError."""
        with self._changed:
            self._pace = checked_pace(pace, "pace")
            self._due = monotonic()
            self._changed.notify()

    # The thread.

    def _run(self) -> None:
        while True:
            with self._changed:
                if self._closed:
                    return
                waiting = self._advance()
                scan, stale = self._wanted, self._stale
                idle = scan == self._scan and not stale and self._number > 0
                self._stale = False
                setup, loaded, playing = self._setup, self._loaded, self._playing
                if idle and self._framed_scan == scan:
                    self._changed.wait(waiting)
                    continue
            try:
                self._show(scan, setup, loaded, stale, playing)
            except Exception as error:
                self._failed(scan, error)

    def _failed(self, scan: int, error: Exception) -> None:
        """Reports that a scan cannot be shown; other scans still can."""
        with self._changed:
            self._playing = False
        self._scan = self._framed_scan = scan
        self._number += 1
        message = f"scan {scan} cannot be shown: {type(error).__name__}: {' '.join(str(error).split())[:200]}"
        time = float(self.recording.stamps[scan])
        self._frame = Frame(self._number, time, None, 0.0, 0.0, 0.0, "", {}, 0.0, message=message)

    def _advance(self) -> float | None:
        """Advances to the next scan if it is due; else returns the time [s] until then, None while paused."""
        if not self._playing:
            return None
        if self._wanted == self.scans - 1:
            self._playing = False
            return None
        now = monotonic()
        waiting = self._due - now
        if waiting > 0.0 or self._number == 0:
            return max(waiting, 0.0)
        if waiting < -MAX_LAG:
            self._due = now
        self._wanted += 1
        if self._wanted < self.scans - 1:
            gap = float(self.recording.stamps[self._wanted + 1] - self.recording.stamps[self._wanted])
            self._due += min(gap, LONGEST_WAIT) / self._pace
        return 0.0

    def _show(self, scan: int, setup: Setup, loaded: Setup, stale: bool, playing: bool) -> None:
        if stale:
            self._take(setup, loaded)
        self._planner.show(scan)
        if self._before is not None:
            self._before.show(scan)
        self._scan = scan
        now = monotonic()
        if playing and not stale and now - self._shown < MIN_FRAME_PERIOD:
            return
        self._shown, self._framed_scan = now, scan
        self._frame = self._framed(scan)

    def _take(self, setup: Setup, loaded: Setup) -> None:
        """Updates the planners of the current and, if it differs, the loaded setup."""
        self._planner = self._taken(self._planner, setup)
        if setup.driver != loaded.driver or setup.values() == loaded.values():
            self._before = None
        elif self._before is None or self._before.driving.setup != loaded:
            self._before = Planner(self.recording, loaded, self.car)

    def _taken(self, planner: Planner, setup: Setup) -> Planner:
        self._message = ""
        try:
            if planner.driving.setup.driver != setup.driver:
                return Planner(self.recording, setup, self.car)
            planner.take(setup)
        except InputError as error:
            self._message = str(error)
        return planner

    def _framed(self, scan: int) -> Frame:
        recording, planner = self.recording, self._planner
        self._number += 1
        pose = self._pose(scan)
        distance, offset = self._place(pose)
        speed, yaw_rate, steering_angle = recording.states[scan].tolist()
        return Frame(
            number=self._number,
            time=float(recording.stamps[scan]),
            pose=pose,
            speed=speed,
            yaw_rate=yaw_rate,
            steering_angle=steering_angle,
            driver=planner.driving.kind.name,
            trace=planner.traced(),
            step_us=planner.step_us,
            distance=distance,
            offset=offset,
            laps=self._laps_until(scan),
            before=None if self._before is None else self._before.traced(),
            message=self._message,
        )

    def _pose(self, scan: int) -> Pose | None:
        if self.recording.poses is None:
            return None
        x, y, yaw = self.recording.poses[scan].tolist()
        return (x, y, yaw) if math.isfinite(x + y + yaw) else None

    def _place(self, pose: Pose | None) -> tuple[float | None, float | None]:
        """Position along and left of the map's centerline [m]."""
        if pose is None or self.track is None:
            return None, None
        line = self.track.centerline
        away = np.array(pose[:2]) - line
        i = int(np.argmin(np.hypot(*away.T)))
        ahead = line[(i + 1) % len(line)] - line[i - 1]
        left = (ahead[0] * away[i, 1] - ahead[1] * away[i, 0]) / max(float(np.hypot(*ahead)), 1e-9)
        return float(self.track.stations[i]), float(left)

    def _laps_until(self, scan: int) -> tuple[DrivenLap, ...]:
        return tuple(lap for after, lap in self._laps if after <= scan)


def laps_of(recording: Recording) -> list[tuple[int, DrivenLap]]:
    """Complete laps, each with the number of the first scan after it; empty without poses."""
    book, found, count = LapBook(), list[tuple[int, DrivenLap]](), 0
    book.lap_setup.by(recording.about.setup if recording.about else None)
    for scan, pose in enumerate(() if recording.poses is None else recording.poses.tolist()):
        if math.isfinite(sum(pose)):
            book.add(float(recording.stamps[scan]), tuple(pose), float(recording.speed[scan]))
        if book.laps and book.laps[-1].number > count:
            count = book.laps[-1].number
            found.append((scan, book.laps[-1]))
    return found


def track_under(recording: Recording, map_path: str | Path) -> Track:
    """The track of the map in which the recording has poses. Raises InputError."""
    from firstlap.evaluation.perception.ground_truth import GroundTruth
    from firstlap.evaluation.perception.map_comparison import check_on_map
    from firstlap.tracks.library import load_track

    if recording.poses is None:
        raise InputError(f"--map: {recording.name} has no poses, so it cannot be placed on a map")
    track = load_track(str(map_path))
    check_on_map(recording, GroundTruth.of(track), recording.poses, map_path)
    return track
