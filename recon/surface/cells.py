"""The dense cloud of many views: one point per cell, as sure as its views make it."""

import numpy as np
from numpy.typing import NDArray

from recon.records import PointCloud
from recon.surface.depth import DepthMap

Array = NDArray[np.float64]
_MOST_ROWS = 4_000_000
"""Rows that wait before they are put together."""
_REACH = 2**20
_BITS = 21


class CellCloud:
    """Weighted means of the points in each cell of a grid.

    Parameters
    ----------
    cell : float
        Side of a cell, world units.
    """

    def __init__(self, cell: float) -> None:
        self.cell = cell
        self._codes: list[NDArray[np.int64]] = []
        self._sums: list[Array] = []

    def add(self, view: DepthMap) -> None:
        """Take the points of a view."""
        mask = view.valid_mask
        points, weight = view.points(mask), 1.0 / view.sigma[mask].astype(np.float64) ** 2
        agreeing = np.ones(len(points)) if view.num_views is None else view.num_views[mask]
        columns = [weight, np.ones(len(points)), agreeing]
        columns += [*(points * weight[:, None]).T, *(view.colours[mask] * weight[:, None]).T]
        codes, sums = _merged(self._code(points), np.stack(columns, axis=1))
        # Errors of one view go together: its points in a cell are as sure as one of them.
        sums[:, 0] /= sums[:, 1]
        sums[:, 3:] /= sums[:, 1:2]
        sums[:, 1] = 1.0
        self._codes.append(codes)
        self._sums.append(sums)
        if sum(map(len, self._codes)) > _MOST_ROWS:
            self._put_together()

    def cloud(self) -> PointCloud:
        """The points (world), with sigma, and `views`: how many views agree on each."""
        if not self._codes:
            nothing = np.zeros((0, 3))
            return PointCloud(
                points=nothing, colours=nothing.astype(np.uint8), sigma=np.zeros(0),
                attributes={"views": np.zeros(0, np.uint8)},
            )  # fmt: skip
        self._put_together()
        weight, count, agreeing, *means = self._sums[0].T
        x, y, z, red, green, blue = (mean / weight for mean in means)
        views = np.maximum(count, agreeing).clip(0, 255)
        return PointCloud(
            points=np.stack([x, y, z], axis=1),
            colours=np.rint(np.stack([red, green, blue], axis=1)).clip(0, 255).astype(np.uint8),
            sigma=1.0 / np.sqrt(weight),
            attributes={"views": views.astype(np.uint8)},
        )

    def _code(self, points: Array) -> NDArray[np.int64]:
        x, y, z = np.floor(points / self.cell).astype(np.int64).T + _REACH
        codes: NDArray[np.int64] = (x << 2 * _BITS) + (y << _BITS) + z
        return codes

    def _put_together(self) -> None:
        codes, sums = _merged(np.concatenate(self._codes), np.concatenate(self._sums))
        self._codes, self._sums = [codes], [sums]


def _merged(codes: NDArray[np.int64], rows: Array) -> tuple[NDArray[np.int64], Array]:
    """Sums of the rows of each cell; of column 2 the largest value."""
    order = np.argsort(codes, kind="stable")
    codes, rows = codes[order], rows[order]
    first = np.flatnonzero(np.diff(codes, prepend=-1))
    if not len(first):
        return codes, rows
    sums = np.add.reduceat(rows, first, axis=0)
    sums[:, 2] = np.maximum.reduceat(rows[:, 2], first)
    return codes[first], sums
