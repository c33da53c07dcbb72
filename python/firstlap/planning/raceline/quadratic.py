"""Sparse quadratic programs over blocks of unknowns, one block per kind, solved by piqp."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import sparse

from firstlap.common.errors import missing_extra
from firstlap.tracks.track import FloatArray

FREE = float("inf")


def solver_class() -> Any:
    """piqp's sparse solver. Raises InputError if the extra is not installed."""
    try:
        import piqp
    except ImportError:
        raise missing_extra("the racing line", "piqp", "global") from None
    return piqp.SparseSolver


class Program:
    """min 1/2 z'Pz + c'z with rows low <= Gz <= high and bounds; z is made of blocks of `count` unknowns each."""

    def __init__(self, count: int, blocks: tuple[str, ...]) -> None:
        self.count = count
        self.blocks = {name: i for i, name in enumerate(blocks)}
        total = count * len(blocks)
        self.linear = np.zeros(total)
        self.low, self.high = np.full(total, -FREE), np.full(total, FREE)
        self._squares: list[tuple[sparse.spmatrix, FloatArray]] = []
        self._rows: list[tuple[sparse.spmatrix, FloatArray, FloatArray]] = []

    def part(self, block: str) -> slice:
        """The slice of a block in the vector of unknowns."""
        begin = self.blocks[block] * self.count
        return slice(begin, begin + self.count)

    def across(self, **parts: sparse.spmatrix) -> sparse.spmatrix:
        """Rows over all unknowns from a matrix (R, count) per block; blocks not named get zeros."""
        rows = next(iter(parts.values())).shape[0]
        empty = sparse.csr_matrix((rows, self.count))
        return sparse.hstack([parts.get(name, empty) for name in self.blocks], format="csr")

    def add_squares(self, rows: sparse.spmatrix, target: FloatArray, weight: float) -> None:
        """Adds 1/2 weight |rows z - target|^2 to the cost."""
        root = np.sqrt(weight)
        self._squares.append((root * rows, root * target))

    def add_rows(self, rows: sparse.spmatrix, low: FloatArray | float, high: FloatArray | float) -> None:
        """low <= rows z <= high."""
        shape = rows.shape[0]
        self._rows.append((rows, np.broadcast_to(low, shape), np.broadcast_to(high, shape)))

    def bound(self, block: str, low: FloatArray | float, high: FloatArray | float) -> None:
        """Bounds of a block."""
        self.low[self.part(block)], self.high[self.part(block)] = low, high

    def solve(self) -> dict[str, FloatArray] | None:
        """The blocks at the minimum; None if the solver failed."""
        rows = sparse.vstack([matrix for matrix, _ in self._squares])
        target = np.concatenate([aim for _, aim in self._squares])
        solver = solver_class()()
        solver.settings.eps_abs = 1e-7
        solver.settings.eps_rel = 1e-8
        solver.setup(
            sparse.triu(rows.T @ rows, format="csc"),
            self.linear - rows.T @ target,
            None,
            None,
            sparse.vstack([matrix for matrix, _, _ in self._rows], format="csc"),
            np.concatenate([low for _, low, _ in self._rows]),
            np.concatenate([high for _, _, high in self._rows]),
            self.low,
            self.high,
        )
        status = solver.solve()
        if status.name != "PIQP_SOLVED" and not (
            status.name == "PIQP_MAX_ITER_REACHED" and solver.result.info.primal_res < 1e-4
        ):
            return None
        return {name: np.array(solver.result.x[self.part(name)]) for name in self.blocks}
