"""Columns of many steps, as returned by the core."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

STATUSES = ("ok", "holding", "no_path", "blocked", "bad_scan", "bad_state")
"""In the order of `Status` in the core."""
SEQUENCES = {
    "left": ("x", "y", "age"),
    "right": ("x", "y", "age"),
    "line": ("x", "y", "width", "support"),
    "path": ("s", "x", "y", "yaw", "curvature", "velocity"),
}
"""What the rows of each sequence hold: meters in base_link, rad, 1/m, m/s; age in s; support as of the centerline."""

Columns = Mapping[str, Any]


def rows_of(columns: Columns, name: str) -> list[npt.NDArray[np.float64]]:
    """The sequence `name` of every scan; empty if the driver has none."""
    sizes = columns[f"{name}_size"]
    if len(sizes) == 0:
        return []
    return np.split(columns[name], np.cumsum(sizes)[:-1])
