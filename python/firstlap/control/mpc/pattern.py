"""A sparse matrix with a fixed pattern and changing values."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy import sparse

Indices = npt.NDArray[np.intp]


class Pattern:
    """Collects groups of entries once; afterwards `fill` writes their values to the compressed columns.

    Entries at the same position are added.
    """

    def __init__(self, rows: int, columns: int) -> None:
        self._shape = (rows, columns)
        self._rows: list[Indices] = []
        self._columns: list[Indices] = []
        self._size = 0
        self.values = np.zeros(0)
        self.matrix = sparse.csc_matrix(self._shape)
        self._place = np.zeros(0, dtype=np.intp)

    def group(self, rows: npt.ArrayLike, columns: npt.ArrayLike) -> slice:
        """Reserves entries; returns the slice of `values` for them."""
        rows, columns = np.broadcast_arrays(np.asarray(rows, dtype=np.intp), np.asarray(columns, dtype=np.intp))
        self._rows.append(rows.ravel())
        self._columns.append(columns.ravel())
        begin, self._size = self._size, self._size + rows.size
        return slice(begin, self._size)

    def freeze(self) -> None:
        """Creates the matrix; no more groups can be added."""
        rows, columns = np.concatenate(self._rows), np.concatenate(self._columns)
        key = columns * self._shape[0] + rows
        unique, self._place = np.unique(key, return_inverse=True)
        starts = np.searchsorted(unique // self._shape[0], np.arange(self._shape[1] + 1))
        self.values = np.zeros(self._size)
        data = np.zeros(len(unique))
        self.matrix = sparse.csc_matrix((data, unique % self._shape[0], starts), shape=self._shape)

    def fill(self) -> sparse.csc_matrix:
        """The matrix with the current `values`."""
        self.matrix.data[:] = np.bincount(self._place, weights=self.values, minlength=len(self.matrix.data))
        return self.matrix
