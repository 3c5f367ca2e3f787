"""Blocks of equations: residuals of one kind and their derivatives, for a sparse least squares."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Block:
    """Residuals and their sparse derivatives, by row, column and value."""

    residual: Array
    rows: NDArray[np.intp]
    columns: NDArray[np.intp]
    values: Array

    @classmethod
    def of(cls, residual: Array, derivative: Array, columns: NDArray[np.intp]) -> "Block":
        """Residuals (R,) with derivatives (R, K) by the unknowns of columns (R, K)."""
        rows = np.broadcast_to(np.arange(len(residual))[:, None], derivative.shape)
        return cls(
            residual=residual, rows=rows.ravel(), columns=columns.ravel(),
            values=derivative.ravel(),
        )  # fmt: skip
