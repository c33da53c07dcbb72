"""The arrays of a step's trace as tables: the single list of their names, columns and types, for logs and messages.

A row is a point, a section or a beam. Columns are one or four bytes wide. A table with positions begins with x, y, z
[m] in base_link, so that RViz and Foxglove can display it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from firstlap.perception.scan import ray_ends

Floats = npt.NDArray[np.float64]
Rows = npt.NDArray[Any]
"""(N,) rows of a table's `dtype`."""
Place = Callable[[Mapping[str, Any], tuple[float, float]], Floats]
"""Computes positions (N, 2) [m] in base_link from a trace and the laser's x, y [m]."""

FLOAT, INT, SMALL, FLAG = "<f4", "<i4", "|i1", "|u1"
READ = {FLOAT: np.float64, INT: np.int64, SMALL: np.int8, FLAG: np.uint8}
"""Type of a column -> type in a trace that is read back."""
PLACE = ("x", "y")
HEIGHT = "z"


class Column(NamedTuple):
    """source: path in the trace, joined by dots. fields: names in the table, one per column of the array. kinds: their
    types, either one for all, or one each if the source is a list of tuples."""

    source: str
    fields: tuple[str, ...]
    kinds: tuple[str, ...] = (FLOAT,)

    @property
    def typed(self) -> list[tuple[str, str]]:
        """Name and type of each field."""
        kinds = self.kinds if len(self.kinds) > 1 else self.kinds * len(self.fields)
        return list(zip(self.fields, kinds, strict=True))


@dataclass(frozen=True)
class Table:
    """A table. place: computes positions for display if the table has none; they are not read back."""

    name: str
    columns: tuple[Column, ...]
    place: Place | None = None

    @cached_property
    def dtype(self) -> np.dtype[Any]:
        """The type of a row, which begins with the position."""
        listed = [one for column in self.columns for one in column.typed]
        listed = [(name, FLOAT) for name in PLACE] * (self.place is not None) + listed
        at = next((i for i, (name, _) in enumerate(listed) if name == PLACE[-1]), None)
        if at is not None:
            listed.insert(at + 1, (HEIGHT, FLOAT))
        return np.dtype(listed)

    def rows(self, trace: Mapping[str, Any], laser: tuple[float, float] = (0.0, 0.0)) -> Rows:
        """The rows of a trace. laser: its x, y [m]. Raises ValueError if the arrays do not form a table."""
        sources = [np.asarray(_found(trace, column.source)) for column in self.columns]
        rows = np.zeros(len(sources[0]), self.dtype)
        for column, source in zip(self.columns, sources, strict=True):
            if len(source) != len(rows):
                raise ValueError(f"{column.source} has {len(source)} rows; expected {len(rows)} as in {self.name}")
            values = source.reshape(len(rows), len(column.fields))
            for i, name in enumerate(column.fields):
                rows[name] = values[:, i]
        if self.place is not None:
            rows["x"], rows["y"] = self.place(trace, laser).T
        return rows

    def put(self, trace: dict[str, Any], rows: Rows) -> None:
        """Puts the columns back into a trace."""
        for column in self.columns:
            if len(column.kinds) > 1:
                value: Any = [tuple(row) for row in rows[list(column.fields)].tolist()]
            else:
                with np.errstate(invalid="ignore"):  # NaN stays NaN
                    arrays = [rows[name].astype(READ[column.kinds[0]]) for name in column.fields]
                value = arrays[0] if len(arrays) == 1 else np.column_stack(arrays)
            put(trace, column.source, value)


def put(trace: dict[str, Any], path: str, value: Any) -> None:
    """Puts a value at a path of names joined by dots. Raises ValueError if there is something else."""
    *folders, name = path.split(".")
    for folder in folders:
        trace = trace.setdefault(folder, {})
        if not isinstance(trace, dict):
            raise ValueError(f"{path[:80]}: {folder[:40]} is a number")
    if name in trace:
        raise ValueError(f"{path[:80]} comes twice")
    trace[name] = value


def _found(trace: Mapping[str, Any], path: str) -> Any:
    found: Any = trace
    try:
        for name in path.split("."):
            found = found[name]
    except (KeyError, TypeError, IndexError):
        raise ValueError(f"the trace has no {path}") from None
    return found


def _beam_ends(source: str) -> Place:
    """Endpoints of the beams, right to left."""

    def ends(trace: Mapping[str, Any], laser: tuple[float, float]) -> Floats:
        ranges = np.asarray(trace[source], dtype=np.float64)
        return ray_ends(laser, trace["first_beam"] + trace["beam_step"] * np.arange(len(ranges)), ranges)

    return ends


def _heading_ends(trace: Mapping[str, Any], laser: tuple[float, float]) -> Floats:
    """Endpoints of the free distances of `gap`, of which the middle one is straight ahead."""
    free = np.asarray(trace["free"], dtype=np.float64)
    return ray_ends(laser, trace["step"] * (np.arange(len(free)) - len(free) // 2), free)


def _corners(trace: Mapping[str, Any], laser: tuple[float, float]) -> Floats:
    """The returns at the disparities."""
    return _beam_ends("ranges")(trace, laser)[np.asarray(trace["disparities"], dtype=np.intp)]


def _side(name: str) -> Table:
    return Table(
        name,
        (
            Column(f"{name}.points", PLACE),
            Column(f"{name}.outward", ("outward_x", "outward_y")),
            Column(f"{name}.age", ("age",)),
        ),
    )


TRAJECTORY = Table(
    "trajectory", tuple(Column(f"path.{name}", (name,)) for name in ("x", "y", "yaw", "curvature", "velocity", "s"))
)
"""The planned path with its speeds [m, rad, 1/m, m/s]."""
BEAMS = Table("beams", (Column("ranges", ("range",)),), _beam_ends("ranges"))

TABLES: dict[str, tuple[Table, ...]] = {
    "local": (
        Table(
            "points",
            (
                Column("points", PLACE),
                Column("point_range", ("range",)),
                Column("point_beam", ("beam",), (INT,)),
            ),
        ),
        Table(
            "sections",
            (
                Column("sections.first", ("first",), (INT,)),
                Column("sections.last", ("last",), (INT,)),
                Column("sections.nearest", ("nearest",)),
                Column("sections.length", ("length",)),
                Column("sections.angle", ("angle",)),
                Column("sections.status", ("status",), (FLAG,)),
            ),
        ),
        Table(
            "samples",
            (
                Column("samples", PLACE),
                Column("sample_section", ("section",), (INT,)),
                Column("sample_vote", ("vote",), (SMALL,)),
            ),
        ),
        Table("candidates", (Column("candidates", ("split", "score"), (INT, FLOAT)),)),
        _side("left"),
        _side("right"),
        Table(
            "line",
            (
                Column("line.points", PLACE),
                Column("line.width", ("width",)),
                Column("line.left", ("left_x", "left_y")),
                Column("line.right", ("right_x", "right_y")),
                Column("line.support", ("support",), (FLAG,)),
            ),
        ),
        Table("smoothed", (Column("smoothed", PLACE),)),
        Table("simplified", (Column("simplified", PLACE),)),
        TRAJECTORY,
    ),
    "gap": (BEAMS, Table("free", (Column("free", ("free",)),), _heading_ends)),
    "disparity": (
        BEAMS,
        Table("extended", (Column("extended", ("range",)),), _beam_ends("extended")),
        Table("disparities", (Column("disparities", ("beam",), (INT,)),), _corners),
    ),
    "pid": (BEAMS,),
    "global": (
        BEAMS,
        Table("map", (Column("map", PLACE),)),
        Table("line", (Column("line", PLACE), Column("line_speed", ("velocity",)))),
        Table(
            "plan",
            (
                Column("plan", (*PLACE, "yaw")),
                Column("plan_speed", ("velocity",)),
                Column("plan_time", ("time",)),
                Column("line_speed_ahead", ("line_velocity",)),
                Column("left", ("left",)),
                Column("right", ("right",)),
            ),
        ),
        Table("inputs", (Column("plan_accel", ("acceleration",)), Column("plan_steering", ("steering_angle",)))),
    ),
}
"""Driver -> its tables; each array of its trace is in one of them."""
TABLE_NAMES = tuple(dict.fromkeys(table.name for tables in TABLES.values() for table in tables))
