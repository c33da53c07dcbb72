"""Columns of many steps, as returned by the core; docs/results-format.md lists them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from firstlap import _core

STATUSES = _core.STATUSES
"""Names of a step's status, by its number."""
PATH_COLUMNS = tuple(column["name"] for column in _core.result_tables()["path"])
"""Columns of a logged path."""

Columns = Mapping[str, Any]


def rows_of(columns: Columns, name: str) -> list[npt.NDArray[np.float64]]:
    """The sequence `name` of every scan; empty if the driver has none."""
    sizes = columns[f"{name}_size"]
    if len(sizes) == 0:
        return []
    return np.split(columns[name], np.cumsum(sizes)[:-1])
