"""Geometry for the scene: flat drawings as points, segments and triangles."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from firstlap.perception.scan import ray_ends
from firstlap.pitwall.frame import Points, Pose

Segments = npt.NDArray[np.float32]
"""(N, 2, 3) [m]: start and end of each segment."""
Vertices = npt.NDArray[np.float32]
"""(N, 3) [m]"""
Faces = npt.NDArray[np.uint32]
"""(N, 3) indices of vertices, counterclockwise from above."""
Mesh = tuple[Vertices, Faces]
Quaternion = tuple[float, float, float, float]

NOTHING: Points = np.zeros((0, 2))


def found_in(trace: Mapping[str, Any], names: tuple[str, ...]) -> npt.NDArray[np.float64]:
    """The numbers under a path of names in a trace; empty if there are none."""
    found: Any = trace
    for name in names:
        found = found.get(name) if isinstance(found, Mapping) else None
    try:
        return np.asarray([] if found is None else found, dtype=float)
    except (TypeError, ValueError):
        return np.zeros(0)


def points_in(trace: Mapping[str, Any], *names: str) -> Points:
    """(N, 2) points under a path of names in a trace; empty if there are none. Never raises."""
    points = found_in(trace, names)
    if points.ndim != 2 or points.shape[1] < 2:
        return NOTHING
    return points[np.isfinite(points[:, :2]).all(axis=1), :2]


def column_in(trace: Mapping[str, Any], *names: str) -> npt.NDArray[np.float64]:
    """(N,) values under a path of names in a trace; empty if there are none. Never raises."""
    values = found_in(trace, names)
    return values if values.ndim == 1 else np.zeros(0)


def number_in(trace: Mapping[str, Any], *names: str) -> float:
    """The number under a path of names in a trace; NaN if there is none. Never raises."""
    value = found_in(trace, names)
    return float(value) if value.ndim == 0 else math.nan


def multiples(step: float, counts: npt.NDArray[np.float64], offset: float = 0.0) -> npt.NDArray[np.float64]:
    """offset + step * counts; NaN instead of infinities, since a received trace may hold any number."""
    with np.errstate(over="ignore", invalid="ignore"):
        values = offset + step * counts
    return np.where(np.isfinite(values), values, np.nan)


def beam_angles(trace: Mapping[str, Any], count: int) -> npt.NDArray[np.float64]:
    """(count,) beam angles [rad], right to left; NaN if the trace has none."""
    beams = np.arange(count, dtype=np.float64)
    return multiples(number_in(trace, "beam_step"), beams, number_in(trace, "first_beam"))


def returns_in(trace: Mapping[str, Any], laser: tuple[float, float]) -> Points:
    """(N, 2) returns in base_link [m] of a trace's ranges by beam, right to left. laser: x, y [m]."""
    ranges = column_in(trace, "ranges")
    ends = ray_ends(laser, beam_angles(trace, len(ranges)), np.where(ranges > 0.0, ranges, np.nan))
    return ends[np.isfinite(ends).all(axis=1)]


def raised(points: Points, height: float) -> Vertices:
    """(N, 3): the points at a height [m]."""
    return np.column_stack([points, np.full(len(points), height)]).astype(np.float32)


def chain(points: Points, height: float) -> Segments:
    """(N - 1, 2, 3): segments from each point to the next."""
    return joined(points[:-1], points[1:], height)


def joined(begin: Points, end: Points, height: float) -> Segments:
    """(N, 2, 3): segments from each point of `begin` to the same one of `end`."""
    return np.stack([raised(begin, height), raised(end, height)], axis=1)


def dashed(points: Points, height: float, on: float, off: float) -> Segments:
    """(N, 2, 3): a polyline as dashes of length `on` with gaps `off` [m]."""
    if len(points) < 2:
        return chain(NOTHING, height)
    s = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    begin = np.arange(0.0, s[-1], on + off)

    def at(query: npt.NDArray[np.float64]) -> Points:
        return np.column_stack([np.interp(query, s, points[:, 0]), np.interp(query, s, points[:, 1])])

    return joined(at(begin), at(np.minimum(begin + on, s[-1])), height)


def resampled(values: npt.NDArray[np.float64], count: int) -> npt.NDArray[np.float64]:
    """(count, ...) rows interpolated evenly by index; needs at least one row."""
    at = np.linspace(0.0, len(values) - 1.0, count)
    columns = values.reshape(len(values), -1)
    rows = np.column_stack([np.interp(at, np.arange(len(values)), column) for column in columns.T])
    return rows.reshape((count, *values.shape[1:]))


def padded(points: Vertices, step: int) -> Vertices:
    """Pads with copies of the last point to a multiple of `step`, so that browsers can reuse their buffers."""
    missing = -len(points) % step
    return np.vstack([points, np.repeat(points[-1:], missing, axis=0)]) if missing else points


def circle(middle: Points, radius: float, height: float) -> Segments:
    """A ring of lines around a point (2,)."""
    angle = np.linspace(0.0, 2.0 * math.pi, 33)
    return chain(middle + radius * np.column_stack([np.cos(angle), np.sin(angle)]), height)


def rotation_about_z(yaw: float) -> Quaternion:
    """Quaternion w, x, y, z of a rotation by `yaw` [rad] about z."""
    return math.cos(0.5 * yaw), 0.0, 0.0, math.sin(0.5 * yaw)


def compose(a: Pose, b: Pose) -> Pose:
    """Composition of two poses: b, given in frame a, in the parent frame of a."""
    c, s = math.cos(a[2]), math.sin(a[2])
    return a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], a[2] + b[2]


def inverse(a: Pose) -> Pose:
    """The inverse pose: the parent frame's origin in frame a."""
    c, s = math.cos(a[2]), math.sin(a[2])
    return -c * a[0] - s * a[1], s * a[0] - c * a[1], -a[2]


def prism(outline: Points, low: float, high: float) -> Mesh:
    """A prism over a convex, counterclockwise outline."""
    n = len(outline)
    vertices = np.vstack([raised(outline, low), raised(outline, high)])
    top = [(n, n + i, n + i + 1) for i in range(1, n - 1)]
    sides = [face for i in range(n) for face in _wall(i, (i + 1) % n, n)]
    return vertices, np.array(top + sides, dtype=np.uint32)


def _wall(i: int, j: int, n: int) -> list[tuple[int, int, int]]:
    return [(i, j, n + j), (i, n + j, n + i)]


def merged(meshes: list[Mesh]) -> Mesh:
    """One mesh of all."""
    counts = np.cumsum([0, *(len(vertices) for vertices, _ in meshes)])
    faces = [faces + np.uint32(count) for (_, faces), count in zip(meshes, counts[:-1], strict=True)]
    return np.vstack([vertices for vertices, _ in meshes]), np.vstack(faces).astype(np.uint32)


def wall_mesh(points: Points, height: float) -> Mesh:
    """A thin wall along a polyline."""
    n = len(points)
    vertices = np.vstack([raised(points, 0.0), raised(points, height)])
    faces = [face for i in range(n - 1) for face in _wall(i, i + 1, n)]
    return vertices, np.array(faces, dtype=np.uint32).reshape(-1, 3)


def disc(radius: float, height: float = 0.0, corners: int = 24) -> Mesh:
    """A flat disc around the origin."""
    return prism(_circle(radius, corners), height, height)


def ring(radius: float, width: float, corners: int = 32) -> Mesh:
    """A flat ring around the origin; radius: mean of inner and outer."""
    rims = [_circle(radius + side * width, corners) for side in (-0.5, 0.5)]
    faces = [face for i in range(corners) for face in _wall(i, (i + 1) % corners, corners)]
    return raised(np.vstack(rims), 0.0), np.array(faces, dtype=np.uint32)


def moved(mesh: Mesh, x: float, y: float) -> Mesh:
    """The mesh, translated by x, y [m]."""
    return mesh[0] + np.array([x, y, 0.0], np.float32), mesh[1]


def _circle(radius: float, corners: int) -> Points:
    angle = np.linspace(0.0, 2.0 * math.pi, corners, endpoint=False)
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


def fan_faces(rim: int) -> Faces:
    """Faces of vertices that are a center and `rim` points around it, right to left."""
    return np.array([(0, i, i + 1) for i in range(1, rim)], dtype=np.uint32)


def arrow(length: float, width: float, head: float) -> Mesh:
    """A flat arrow along x from the origin, its shaft `width` wide and its head `head` long."""
    half, wide, neck = 0.5 * width, 0.6 * head, length - head
    corners = np.array(
        [[0.0, -half], [neck, -half], [neck, half], [0.0, half], [neck, -wide], [length, 0], [neck, wide]]
    )
    return raised(corners, 0.0), np.array([(0, 1, 2), (0, 2, 3), (4, 5, 6)], dtype=np.uint32)
