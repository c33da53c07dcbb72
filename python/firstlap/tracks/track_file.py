"""Reads our own track files: YAML, in meters; `KEYS` lists the allowed keys."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import shapely

from firstlap.common.errors import InputError
from firstlap.common.yaml_text import parse_mapping, read_text
from firstlap.tracks.assemble import assemble
from firstlap.tracks.corridor import check_line, corner_line, corridor_walls, spline_line
from firstlap.tracks.cut_walls import with_low_wall, with_pipes, with_scenery
from firstlap.tracks.map_header import number
from firstlap.tracks.track import FloatArray, Track

KEYS = {
    "name": "the track's name; default: the file's",
    "description": "purpose of the track, one line",
    "corners": "[x, y, radius, width_right, width_left] each: straights and arcs; radius 0 only sets widths",
    "centerline": "[x, y, width_right, width_left] each: a smooth closed curve through these points",
    "walls": "{side: left|right|obstacle, points: [[x, y], ...]} each; beside a line: obstacles only",
    "start": "[x, y] or [x, y, yaw]: the start line is at this point; default: on the longest straight",
    "pipes": "{length: m, joint: m or [m, ...]}: cuts the walls into pipes with joints",
    "low_wall": "{side: left|right, from: m, to: m, post: m, gap: m} each: only posts are visible to the LiDAR",
    "scenery": "polylines [[x, y], ...] each: visible to the LiDAR, outside of the track",
}
MAX_POINTS = 20_000


def load_track_file(path: str | Path) -> Track:
    """The track in one of our track files. Raises InputError with file, key and expected value."""
    path = Path(path)
    return parse_track(read_text(path), str(path))


def parse_track(text: str, where: str) -> Track:
    """The track in the text of one of our track files; `where` names the file in messages. Raises InputError."""
    data = parse_mapping(text, where)
    for key in data:
        if key not in KEYS:
            raise InputError(f"{where}: unknown key {str(key)[:40]!r}; expected {', '.join(KEYS)}")
    if ("corners" in data) + ("centerline" in data) > 1 or not {"corners", "centerline", "walls"} & set(data):
        raise InputError(f"{where}: expected one of corners, centerline or walls")
    name = data.get("name", Path(where).stem)
    if not isinstance(name, str):
        raise InputError(f"{where}: name is {name!r}; expected text")
    try:
        left, right, obstacles = _walls(data, where)
        _check_walls(left, right, obstacles, where)
        track = assemble(name, left, right, obstacles, source=where, start=_start(data, where))
        return _with_extras(track, data, where)
    except (shapely.errors.ShapelyError, ValueError) as error:
        raise InputError(f"{where}: cannot be made into a track ({error})") from None


def _walls(data: dict[str, Any], where: str) -> tuple[list[FloatArray], list[FloatArray], list[FloatArray]]:
    sides: dict[str, list[FloatArray]] = {"left": [], "right": [], "obstacle": []}
    for i, wall in enumerate(_list(data.get("walls", []), "walls", where)):
        key = f"walls[{i}]"
        fields = _fields(wall, ("side", "points"), key, where)
        if fields["side"] not in tuple(sides):
            raise InputError(f"{where}: {key}.side is {fields['side']!r}; expected left, right or obstacle")
        points = _table(fields["points"], 2, f"{key}.points", where, least=3)
        closed = points if np.allclose(points[0], points[-1]) else np.vstack([points, points[:1]])
        sides[fields["side"]].append(closed)
    if "corners" in data or "centerline" in data:
        if sides["left"] or sides["right"]:
            raise InputError(f"{where}: with corners or centerline, walls may only be obstacles")
        left, right = corridor_walls(_line(data, where), where)
        return [left], [right], sides["obstacle"]
    if not sides["left"] or not sides["right"]:
        raise InputError(f"{where}: walls need at least one left and one right wall")
    return sides["left"], sides["right"], sides["obstacle"]


def _line(data: dict[str, Any], where: str) -> FloatArray:
    key, columns = ("corners", 5) if "corners" in data else ("centerline", 4)
    points = _table(data[key], columns, key, where, least=3)
    if np.allclose(points[0], points[-1]):
        points = points[:-1]
    check_line(points, key, where)
    if key == "corners" and (points[:, 2] < 0.0).any():
        raise InputError(f"{where}: corners has a negative radius; expected a positive radius")
    return corner_line(points, where) if key == "corners" else spline_line(points)


def _check_walls(left: list[FloatArray], right: list[FloatArray], obstacles: list[FloatArray], where: str) -> None:
    rings = [shapely.LinearRing(wall) for wall in (*left, *right, *obstacles)]
    for ring in rings:
        if not ring.is_simple:
            raise InputError(f"{where}: a wall crosses itself; expected a simple closed line")
    for i, ring in enumerate(rings):
        if any(ring.intersects(other) for other in rings[:i]):
            raise InputError(f"{where}: two walls cross or touch; expected separate walls")


def _start(data: dict[str, Any], where: str) -> tuple[float, float, float | None] | None:
    start = data.get("start")
    if start is None:
        return None
    if not isinstance(start, list) or len(start) not in (2, 3):
        raise InputError(f"{where}: start is {str(start)[:40]}; expected [x, y] or [x, y, yaw]")
    values = [number(value, "start", where) for value in start]
    return values[0], values[1], values[2] if len(values) == 3 else None


def _with_extras(track: Track, data: dict[str, Any], where: str) -> Track:
    for i, low in enumerate(_list(data.get("low_wall", []), "low_wall", where)):
        key = f"low_wall[{i}]"
        fields = _fields(low, ("side", "from", "to", "post", "gap"), key, where)
        if fields["side"] not in ("left", "right"):
            raise InputError(f"{where}: {key}.side is {fields['side']!r}; expected left or right")
        begin, end, post, gap = (number(fields[k], f"{key}.{k}", where) for k in ("from", "to", "post", "gap"))
        if not 0.0 <= begin < end <= track.length or post <= 0.0 or gap <= 0.0:
            raise InputError(f"{where}: {key} expects 0 <= from < to <= {track.length:.1f} m, post and gap above 0")
        track = with_low_wall(track, fields["side"], begin, end, post, gap)
    if "pipes" in data:
        fields = _fields(data["pipes"], ("length", "joint"), "pipes", where)
        joints = fields["joint"] if isinstance(fields["joint"], list) else [fields["joint"]]
        joint_lengths = [number(joint, "pipes.joint", where) for joint in joints]
        length = number(fields["length"], "pipes.length", where)
        if length < 0.1 or not joint_lengths or min(joint_lengths) <= 0.0 or max(joint_lengths) > length:
            raise InputError(f"{where}: pipes expects length >= 0.1 m and joints above 0 and no longer than a pipe")
        track = with_pipes(track, length, joint_lengths)
    scenery = [
        _table(line, 2, f"scenery[{i}]", where, least=2)
        for i, line in enumerate(_list(data.get("scenery", []), "scenery", where))
    ]
    return with_scenery(track, scenery) if scenery else track


def _list(value: Any, key: str, where: str) -> list[Any]:
    if not isinstance(value, list) or len(value) > 1000:
        raise InputError(f"{where}: {key} is {str(value)[:40]}; expected a list")
    return value


def _fields(value: Any, names: tuple[str, ...], key: str, where: str) -> dict[str, Any]:
    if not isinstance(value, dict) or set(value) != set(names):
        raise InputError(f"{where}: {key} is {str(value)[:60]}; expected {{{', '.join(names)}}}")
    return value


def _table(value: Any, columns: int, key: str, where: str, *, least: int) -> FloatArray:
    """(N, columns) finite numbers."""
    if not isinstance(value, list) or not least <= len(value) <= MAX_POINTS:
        raise InputError(f"{where}: {key} is {str(value)[:40]}; expected a list of {least} or more points")
    for i, row in enumerate(value):
        if not isinstance(row, list) or len(row) != columns:
            raise InputError(f"{where}: {key}[{i}] is {str(row)[:40]}; expected {columns} numbers")
    return np.array([[number(item, f"{key}[{i}]", where) for item in row] for i, row in enumerate(value)])
