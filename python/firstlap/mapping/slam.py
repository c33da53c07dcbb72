"""Scan matching against a local submap, and loop closure (Lu and Milios 1997)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from firstlap import _core
from firstlap.common.errors import InputError
from firstlap.mapping.observation import Observation
from firstlap.mapping.parameters import MapSettings
from firstlap.mapping.poses import between, compose, transform_cloud, wrap
from firstlap.tracks.track import FloatArray

POOR_FIT = 0.35
NO_PRIOR = (1e6, 1e6, 1e6)
SEARCH_STEP, SEARCH_TURN = 0.1, 0.03
LOOP_BEHIND, LOOP_AHEAD = 6, 12
FEWEST_RATIOS, ALONG_SHARE = 10, 0.3


@dataclass
class Keyframe:
    """A keyframe. cloud (N, 4) and points (P, 3) in base_link; odometry (3,) from the previous keyframe."""

    pose: FloatArray
    cloud: FloatArray
    points: FloatArray
    odometry: FloatArray
    traveled: float
    time: float
    reference: _core.ReferenceCloud | None = None

    def as_reference(self) -> _core.ReferenceCloud:
        """The cloud as a matching reference, cached."""
        if self.reference is None:
            self.reference = _core.ReferenceCloud(self.cloud)
        return self.reference


@dataclass(frozen=True)
class Edge:
    """Pose (3,) of keyframe `last` in the frame of keyframe `first`; information (3, 3) in the frame of `last`."""

    first: int
    last: int
    pose: FloatArray
    information: FloatArray
    loop: bool = False


@dataclass
class Mapper:
    """Selects keyframes, estimates their poses and detects loop closures.

    The frame is base_link at the first scan.
    """

    settings: MapSettings
    car: _core.Car
    keyframes: list[Keyframe] = field(default_factory=list)
    loops: list[Edge] = field(default_factory=list)
    closed_at: float | None = None

    def __post_init__(self) -> None:
        self._maker = _core.CloudMaker(self.settings.core, self.car)
        self._motion = np.zeros(3)
        self._pending: list[tuple[Edge, FloatArray]] = []
        self._offset: FloatArray | None = None
        self.traveled = 0.0
        self.scans = 0
        self._time = 0.0
        self._period = _core.ScanPeriod()
        self.poor = 0

    @property
    def closed(self) -> bool:
        """Whether a loop has been closed."""
        return self.closed_at is not None

    @property
    def overlap(self) -> float:
        """Distance driven since the first loop closure [m]."""
        return self.traveled - self.closed_at if self.closed_at is not None else 0.0

    def add(self, seen: Observation) -> bool:
        """Adds one scan and the odometry since the previous one. Returns whether it became a keyframe. Raises
        InputError."""
        if not np.isfinite(seen.motion).all() or abs(seen.motion[:2]).max() > 2.0:
            raise InputError(f"odometry at {seen.time:.3f} s jumps by {seen.motion[:2]} m between two scans")
        if self.scans:
            self._period.learn(seen.time - self._time)
        self._time = seen.time
        self.scans += 1
        self._motion = compose(self._motion, seen.motion) if self.keyframes else np.zeros(3)
        self.traveled += float(np.hypot(*seen.motion[:2])) if self.keyframes else 0.0
        far = np.hypot(*self._motion[:2]) >= self.settings.get("graph.keyframe_distance")
        turned = abs(self._motion[2]) >= self.settings.get("graph.keyframe_angle")
        if self.keyframes and not far and not turned:
            return False
        self._keep(seen, seen.scan())
        return True

    def _keep(self, seen: Observation, scan: _core.LaserScan) -> None:
        try:
            state = _core.VehicleState(seen.speed, seen.yaw_rate)
            cloud, points = self._maker.make(scan, state, self._period.seconds)
        except ValueError as error:
            raise InputError(f"scan at {seen.time:.3f} s: {error}") from None
        pose = self._place(cloud) if self.keyframes else np.zeros(3)
        self.keyframes.append(Keyframe(pose, cloud, points, self._motion, self.traveled, seen.time))
        self._motion = np.zeros(3)
        self._look_for_loop(len(self.keyframes) - 1)

    def _place(self, cloud: FloatArray) -> FloatArray:
        """Pose of a new cloud: predicted by odometry, matched against the last keyframes."""
        guess = compose(self.keyframes[-1].pose, self._motion)
        recent = self.keyframes[-int(self.settings.get("graph.submap_keyframes")) :]
        reference = _core.ReferenceCloud(np.vstack([transform_cloud(k.pose, k.cloud) for k in recent]))
        prior = self.odometry_sigmas(self._motion)
        pose, fit, _, _ = _core.match(cloud, reference, tuple(guess), prior, self.settings.core)
        if fit < POOR_FIT:
            self.poor += 1
            return guess
        return np.array(pose)

    def odometry_sigmas(self, motion: FloatArray) -> tuple[float, float, float]:
        """Longitudinal, lateral [m] and heading [rad] standard deviations of an odometry step."""
        way = float(np.hypot(*motion[:2]))
        along = self.settings.get("graph.odometry_distance") * way + 0.002
        turn = self.settings.get("graph.odometry_angle") * (way + abs(float(motion[2]))) + 0.002
        return along, along + 0.5 * way * turn, turn

    # Loops.

    def _look_for_loop(self, i: int) -> None:
        """Matches keyframe i with the nearest earlier one; a loop is closed if several consecutive matches agree."""
        here = self.keyframes[i]
        expected = compose(self._offset, here.pose) if self._offset is not None else here.pose
        j = self._nearest_earlier(i, expected)
        found = self._match_loop(j, i, expected) if j is not None else None
        if found is None:
            self._pending.clear()
            return
        # The correction of the frame of `here` that the match implies.
        seen_at = compose(self.keyframes[found.first].pose, found.pose)
        offset = compose(seen_at, between(here.pose, np.zeros(3)))
        if self._pending and not self._agree(here.pose, offset, self._pending[-1][1]):
            self._pending.clear()
        self._pending.append((found, offset))
        if len(self._pending) < self.settings.get("graph.loop_agree"):
            return
        self.loops += [edge for edge, _ in self._pending if edge not in self.loops]
        self._pending = self._pending[-1:]
        self._offset = offset
        if self.closed_at is None:
            self.closed_at = self.traveled

    def _agree(self, pose: FloatArray, a: FloatArray, b: FloatArray) -> bool:
        apart = compose(a, pose) - compose(b, pose)
        near = bool(np.hypot(*apart[:2]) <= self.settings.get("graph.loop_agree_distance"))
        return near and bool(abs(wrap(apart[2])) <= self.settings.get("graph.loop_agree_angle"))

    def _gate(self, traveled: float) -> float:
        drift = 0.0 if self._offset is not None else self.settings.get("graph.loop_drift") * traveled
        return self.settings.get("graph.loop_radius") + drift

    def _nearest_earlier(self, i: int, expected: FloatArray) -> int | None:
        traveled = np.array([k.traveled for k in self.keyframes])
        old = int(np.searchsorted(traveled, self.traveled - self.settings.get("graph.loop_travel"), side="right"))
        if old == 0:
            return None
        poses = np.array([k.pose for k in self.keyframes[:old]])
        apart = np.hypot(*(poses[:, :2] - expected[:2]).T)
        turned = np.abs(wrap(poses[:, 2] - expected[2])) > self.settings.get("graph.loop_angle") + 0.5
        gates = self._gate(1.0) if self._offset is not None else self._gates(traveled[:old])
        apart = np.where(turned | (apart > gates), np.inf, apart)
        j = int(np.argmin(apart))
        return j if np.isfinite(apart[j]) else None

    def _gates(self, traveled: FloatArray) -> FloatArray:
        drift = self.settings.get("graph.loop_drift") * (self.traveled - traveled)
        return np.asarray(self.settings.get("graph.loop_radius") + drift)

    def _match_loop(self, j: int, i: int, expected: FloatArray) -> Edge | None:
        """Matches keyframe i with the keyframes around j by a coarse search; None if it does not match."""
        there, here = self.keyframes[j], self.keyframes[i]
        around = self.keyframes[max(0, j - LOOP_BEHIND) : j + LOOP_AHEAD]
        submap = np.vstack([transform_cloud(between(there.pose, k.pose), k.cloud) for k in around])
        guess = tuple(between(there.pose, expected))
        radius = self._gate(self.traveled - there.traveled)
        coarse = here.cloud[:: max(1, len(here.cloud) // 120)]
        searched, _ = _core.LikelihoodField.of_points(submap, 0.05).search(
            coarse, guess, radius, self.settings.get("graph.loop_angle"), SEARCH_STEP, SEARCH_TURN
        )
        reference = _core.ReferenceCloud(submap)
        pose, fit, _, information = _core.match(here.cloud, reference, searched, NO_PRIOR, self.settings.core)
        if fit < self.settings.get("graph.loop_fit"):
            return None
        return Edge(j, i, np.array(pose), information, loop=True)

    # The rest of the graph.

    def edges(self, poses: FloatArray) -> list[Edge]:
        """Matches of each keyframe with those 1, 2, 4, ... before it, starting from poses (N, 3), and the loops."""
        found: list[Edge] = []
        for i, here in enumerate(self.keyframes):
            for step in self._steps():
                if i < step:
                    break
                there = self.keyframes[i - step]
                guess = tuple(between(poses[i - step], poses[i]))
                pose, fit, _, information = _core.match(
                    here.cloud, there.as_reference(), guess, NO_PRIOR, self.settings.core
                )
                if fit >= POOR_FIT and np.hypot(pose[0] - guess[0], pose[1] - guess[1]) < 0.2:
                    found.append(Edge(i - step, i, np.array(pose), information))
        return found + self.loops

    def _steps(self) -> list[int]:
        return [2**k for k in range(int(self.settings.get("graph.edges")))]

    def odometry_scale(self, edges: list[Edge]) -> float:
        """Ratio of true distance to odometry distance: median over the longest matches in which the walls constrain
        both directions. 1 if there are too few."""
        step = self._steps()[-1]
        ratios = []
        for edge in edges:
            if edge.loop or edge.last - edge.first != step:
                continue
            way = np.zeros(3)
            for keyframe in self.keyframes[edge.first + 1 : edge.last + 1]:
                way = compose(way, keyframe.odometry)
            length = float(np.hypot(*way[:2]))
            if length > 0.5 * step * self.settings.get("graph.keyframe_distance") and _tells_along(edge.information):
                ratios.append(float(way[:2] @ edge.pose[:2]) / length**2)
        return float(np.median(ratios)) if len(ratios) >= FEWEST_RATIOS else 1.0


def _tells_along(information: FloatArray) -> bool:
    return bool(information[0, 0] > ALONG_SHARE * information[1, 1])
