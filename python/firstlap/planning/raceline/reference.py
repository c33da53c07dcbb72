"""An independent reference for the minimum-time line: one nonlinear program over the whole lap.

It shares no code with the production line. Unknowns are offset, heading error, speed, curvature and
acceleration at stations of the centerline; the equations of motion are collocated by the trapezoidal rule; a smooth
signed distance to the walls, sampled on a grid, keeps points around the car's rectangle clear; casadi's exact
derivatives and ipopt solve it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import shapely
from scipy.ndimage import gaussian_filter1d

from firstlap.common.errors import missing_extra
from firstlap.config.car_file import Car
from firstlap.planning.raceline.params import Limits, LineParams, limits_of
from firstlap.tracks.track import FloatArray, Track

GRID = 0.05
CALM = 1e-5
"""[s m^2] Cost of a squared change of curvature: small, for regularization only."""
NEVER_BOTH = 1e-5
"""[s (s^2/m)^2] Cost of driving and braking at once."""
AROUND = 7
"""Number of points on each side of the car's rectangle that must be clear."""


class Reference(NamedTuple):
    """time [s] of the lap; points (N, 2) of the line; speed (N,) [m/s]; status: of the solver."""

    time: float
    points: FloatArray
    speed: FloatArray
    status: str


class _Frame(NamedTuple):
    """Of the centerline: points (N, 2), heading (N,), curvature (N,) and step to the next point (N,)."""

    center: FloatArray
    heading: FloatArray
    bend: FloatArray
    step: FloatArray


class _Program(NamedTuple):
    """Symbols: the unknowns by name, the lap time, the cost, what must be 0, and the grip that is used, -1 to 1."""

    x: dict[str, Any]
    time: Any
    cost: Any
    zero: list[Any]
    grip: Any


def reference_line(track: Track, car: Car, params: LineParams, spacing: float = 0.15) -> Reference:
    """The minimum-time line of the nonlinear program. Raises InputError if casadi is not installed."""
    try:
        import casadi as ca
    except ImportError:
        raise missing_extra("the reference of the racing line", "casadi", "global") from None
    limits = limits_of(car, params)
    frame = _reference_frame(track, spacing)
    program = _program(ca, frame, limits)
    clear = _clearances(ca, track, car, program.x, frame.center, frame.heading)
    solver = ca.nlpsol(
        "line",
        "ipopt",
        {"x": ca.vertcat(*program.x.values()), "f": program.cost, "g": ca.vertcat(*program.zero, program.grip, *clear)},
        {"ipopt.max_iter": 1500, "ipopt.print_level": 0, "ipopt.sb": "yes", "print_time": False, "ipopt.tol": 1e-5},
    )
    count = len(frame.center)
    low, high = _bounds(track, limits, count)
    equal, rest = len(program.zero) * count, len(clear) * count
    found = solver(
        x0=np.concatenate([np.zeros(2 * count), np.full(count, 2.0), frame.bend, np.full(2 * count, 0.1)]),
        lbx=low,
        ubx=high,
        lbg=np.concatenate([np.zeros(equal), np.full(count, -1.0), np.full(rest, params.margin)]),
        ubg=np.concatenate([np.zeros(equal), np.ones(count), np.full(rest, 1e3)]),
    )
    values = np.asarray(found["x"]).reshape(len(program.x), count)
    normal = np.column_stack([-np.sin(frame.heading), np.cos(frame.heading)])
    seconds = ca.Function("time", list(program.x.values()), [program.time])(*values)
    points = frame.center + values[0][:, None] * normal
    return Reference(float(seconds), points, values[2], solver.stats()["return_status"])


def _program(ca: Any, frame: _Frame, limits: Limits) -> _Program:
    x = {name: ca.MX.sym(name, len(frame.center)) for name in ("n", "xi", "v", "k", "drive", "brake")}
    after = {name: ca.vertcat(value[1:], value[0]) for name, value in x.items()}
    pace = (1.0 - x["n"] * frame.bend) / (x["v"] * ca.cos(x["xi"]))
    rates = {
        "n": x["v"] * ca.sin(x["xi"]) * pace,
        "xi": x["k"] * x["v"] * pace - frame.bend,
        "v": (x["drive"] - x["brake"]) * pace,
    }
    grip = (
        (x["drive"] / limits.grip.drive) ** 2
        + (x["brake"] / limits.grip.brake) ** 2
        + (x["v"] ** 2 * x["k"] / limits.grip.lateral) ** 2
    )
    time = ca.dot(0.5 * (pace + ca.vertcat(pace[1:], pace[0])), frame.step)
    change = (after["k"] - x["k"]) / frame.step
    cost = time + CALM * ca.dot(change**2, frame.step) + NEVER_BOTH * ca.dot(x["drive"], x["brake"])
    zero = [_trapezoid(ca, x[name], after[name], rate, frame.step) for name, rate in rates.items()]
    return _Program(x, time, cost, zero, grip)


def _reference_frame(track: Track, spacing: float) -> _Frame:
    """Of the slightly smoothed centerline."""
    smooth = gaussian_filter1d(track.centerline, 0.25 / 0.1, axis=0, mode="wrap")
    closed = np.vstack([smooth, smooth[:1]])
    s = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(closed, axis=0).T))])
    count = round(s[-1] / spacing)
    at = np.linspace(0.0, s[-1], count, endpoint=False)
    points = np.column_stack([np.interp(at, s, closed[:, 0]), np.interp(at, s, closed[:, 1])])
    points = gaussian_filter1d(points, 1.0, axis=0, mode="wrap")
    # The heading of each chord is taken at its middle, so that heading and curvature are consistent.
    chord = np.roll(points, -1, axis=0) - points
    direction = np.unwrap(np.arctan2(chord[:, 1], chord[:, 0]))
    turns = np.round((direction[-1] - direction[0]) / (2.0 * np.pi)) * 2.0 * np.pi
    before = np.concatenate([[direction[-1] - turns], direction[:-1]])
    heading = 0.5 * (before + direction)
    step = np.hypot(*chord.T)
    return _Frame(points, heading, (direction - before) / (0.5 * (step + np.roll(step, 1))), step)


def _trapezoid(ca: Any, now: Any, after: Any, rate: Any, step: FloatArray) -> Any:
    return after - now - 0.5 * step * (rate + ca.vertcat(rate[1:], rate[0]))


def _clearances(
    ca: Any, track: Track, car: Car, x: dict[str, Any], center: FloatArray, heading: FloatArray
) -> list[Any]:
    """Signed distance to the walls, positive between them, of points around the car's rectangle."""
    body = car.core.values()["geometry"]
    rear, front = -body["rear_overhang"], body["length"] - body["rear_overhang"]
    field = _distance_field(ca, track)
    yaw = heading + x["xi"]
    base_x, base_y = center[:, 0] - x["n"] * np.sin(heading), center[:, 1] + x["n"] * np.cos(heading)
    found = []
    for along in np.linspace(rear, front, AROUND):
        for across in (-0.5 * body["width"], 0.5 * body["width"]):
            px = base_x + along * ca.cos(yaw) - across * ca.sin(yaw)
            py = base_y + along * ca.sin(yaw) + across * ca.cos(yaw)
            found.append(field(ca.horzcat(px, py).T).T)
    return found


def _distance_field(ca: Any, track: Track) -> Any:
    """A cubic spline through signed distances to the solid walls on a grid."""
    corners = np.vstack(track.walls)
    low, high = corners.min(axis=0) - 0.5, corners.max(axis=0) + 0.5
    xs, ys = (np.arange(low[i], high[i] + GRID, GRID) for i in (0, 1))
    solid = [wall for wall, hard in zip(track.walls, track.solid, strict=True) if hard]
    walls = shapely.multilinestrings([shapely.linestrings(wall) for wall in solid])
    middle = shapely.points(track.centerline[:: max(1, len(track.centerline) // 50)])
    pieces = shapely.get_parts(shapely.polygonize([shapely.unary_union(walls)]))
    road = max(pieces, key=lambda piece: int(shapely.contains(piece, middle).sum()))
    shapely.prepare(road)
    shapely.prepare(walls)
    grid_y, grid_x = np.meshgrid(ys, xs, indexing="ij")
    points = shapely.points(grid_x.ravel(), grid_y.ravel())
    sign = np.where(shapely.contains(road, points), 1.0, -1.0)
    values = sign * shapely.distance(points, walls)
    return ca.interpolant("clear", "bspline", [xs, ys], values)


def _bounds(track: Track, limits: Limits, count: int) -> tuple[FloatArray, FloatArray]:
    widest = 0.5 * float(track.width.max()) + 0.5
    high = np.repeat([widest, 1.2, limits.speed, limits.curvature, limits.accel, limits.brake], count)
    low = np.repeat([-widest, -1.2, 0.5, -limits.curvature, 0.0, 0.0], count)
    return low, high
