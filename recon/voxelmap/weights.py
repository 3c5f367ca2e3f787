"""Weights of the points of a cell, by their sigma."""

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.voxelmap.channels import Columns, RowSums, Scan


class Weights(RowSums):
    """Sum of 1 / (1 + (sigma / 0.3 cells)^2): precise points weigh 1, uncertain ones little."""

    name = "weight"
    width = 1
    STEPS = 1 << 20
    SIGMA_OF_HALF = 0.3

    def __init__(self, cell_size: float) -> None:
        super().__init__()
        self.cell_size = cell_size

    def check(self, scan: Scan) -> None:
        """Raise `InputError` if a point has no sigma."""
        if scan.cloud.sigma is None or not (scan.cloud.sigma >= 0).all():
            raise InputError("a cloud has no sigma, but a map that keeps weights needs it")

    def amounts(self, scan: Scan) -> NDArray[np.uint64]:
        """The weights (N, 1), in steps."""
        assert scan.cloud.sigma is not None
        ratio = scan.cloud.sigma / (self.SIGMA_OF_HALF * self.cell_size)
        weights = self.STEPS / (1.0 + ratio * ratio)
        return np.rint(weights).astype(np.uint64)[:, None]

    def fields(self, order: NDArray[np.int64], index: NDArray[np.int64]) -> Columns:
        """`Voxels.weights`."""
        return {"weights": self.of(order)[:, 0] / self.STEPS}
