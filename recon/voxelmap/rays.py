"""Free space: the cells between camera and points, counted once per scan (OctoMap's rule).

Hornung et al., OctoMap, Autonomous Robots 2013, section 5: in one scan a cell with a point is hit,
whatever rays pass through it; any other cell that a ray passes through is passed; each counts once.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.voxelmap.channels import Columns, Inside, Scan
from recon.voxelmap.table import CellTable, Rows, in_order
from recon.voxelmap.traversal import (
    MAX_CELLS,
    Block,
    block_of,
    corners,
    hit_cells,
    merge_cells,
    pass_cells,
)

_DTYPE = np.dtype([("index", "i4", 3), ("hits", "u4"), ("passes", "u4"), ("scan", "u4")])


_LOG_ODDS_HIT = float(np.log(0.7 / 0.3))
_LOG_ODDS_MISS = float(np.log(0.4 / 0.6))
"""OctoMap's default sensor model: a hit is correct in 7 of 10 cases, a pass in 6 of 10."""


def log_odds(hits: NDArray[np.int64], passes: NDArray[np.int64]) -> NDArray[np.float64]:
    """Log-odds (K,) of being occupied, by OctoMap's default sensor.

    They are not clamped, since then the order would matter.
    """
    return _LOG_ODDS_HIT * hits + _LOG_ODDS_MISS * passes


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sightings:
    """Cells that scans hit or passed, ordered by x, then y, then z."""

    index: NDArray[np.int64]
    """(K, 3)"""
    hits: NDArray[np.int64]
    """(K,) scans with a point in the cell."""
    passes: NDArray[np.int64]
    """(K,) scans with a ray through the cell and no point in it."""

    def __len__(self) -> int:
        return len(self.index)


class Rays:
    """Hits and passes of every cell that a scan touched."""

    def __init__(self, cell_size: float, margin: float) -> None:
        self.cell_size = cell_size
        self.margin = margin
        self.table = CellTable(_DTYPE)
        self._num_scans = 0
        self._last_scan = np.zeros(0, np.uint32)

    def check(self, scan: Scan) -> None:
        """Raise `InputError` if the origin is missing or a ray is too long."""
        if scan.origin is None:
            raise InputError("origin is None, but a map that keeps rays needs the camera position")
        low, high = corners(scan.origin, scan.cloud.points)
        reach = float((high - low).max()) / self.cell_size
        if not reach < MAX_CELLS:
            raise InputError(f"a scan is {reach:g} cells wide, but at most {MAX_CELLS} are allowed")

    def add(self, scan: Scan, rows: NDArray[np.int64]) -> None:
        """Count the cells of one scan."""
        self._num_scans += 1
        points = scan.cloud.points
        rays = (scan.origin, self._free_ends(points, scan))
        block = block_of(corners(scan.origin, points), self.cell_size)
        self._count(hit_cells, (points, rows, self._last_scans(rows)), len(points), block)
        self._count(pass_cells, rays, len(points), block)

    def _last_scans(self, rows: NDArray[np.int64]) -> NDArray[np.uint32]:
        """The last scan that hit each row of the map."""
        num_rows = int(rows.max(initial=-1)) + 1
        if num_rows > len(self._last_scan):
            more = np.zeros(num_rows + num_rows // 4 - len(self._last_scan), np.uint32)
            self._last_scan = np.concatenate([self._last_scan, more])
        return self._last_scan

    def _count(self, kernel: Any, things: Any, num: int, block: Block) -> None:
        """Run a kernel over points or rays, growing the table whenever it stops."""
        stop = 0
        while stop < num:
            stop, self.table.num_rows = kernel(
                things, self.cell_size, self._num_scans, block, self.table.arrays, stop
            )
            if stop < num:
                self.table.grow()

    def _free_ends(self, points: NDArray[np.float64], scan: Scan) -> NDArray[np.float64]:
        """Ends (N, 3) of the free part of each ray."""
        assert scan.origin is not None
        if self.margin == 0.0:
            return points
        towards = scan.origin - points
        distance = np.linalg.norm(towards, axis=1)
        margin = np.full(len(points), self.margin * self.cell_size)
        if scan.cloud.sigma is not None:
            margin = np.fmax(margin, 2.0 * scan.cloud.sigma)
        share = np.minimum(margin / np.maximum(distance, 1e-300), 1.0)
        ends: NDArray[np.float64] = points + towards * share[:, None]
        return ends

    def merge(self, other: "Rays", rows: NDArray[np.int64]) -> None:
        """Add the scans of another map."""
        self._add_rows(other.table.used.copy())

    def cropped(self, rows: NDArray[np.int64], is_inside: Inside) -> "Rays":
        """The cells inside."""
        part = Rays(self.cell_size, self.margin)
        part._add_rows(self.table.used[is_inside(self.table.used["index"])])
        return part

    def columns(self, order: NDArray[np.int64]) -> Columns:
        """The cells in the order of their index."""
        rows = in_order(self.table.used)
        names = ("index", "hits", "passes")
        return {f"ray_{name}": rows[name] for name in names}

    def restore(self, columns: Columns, num_rows: int) -> None:
        """Load the cells of a file."""
        rows = np.zeros(len(columns["ray_index"]), _DTYPE)
        for name in ("index", "hits", "passes"):
            rows[name] = columns[f"ray_{name}"]
        self._add_rows(rows)

    def fields(self, order: NDArray[np.int64], index: NDArray[np.int64]) -> Columns:
        """`Voxels.hits` and `Voxels.passes`; every cell with a point was hit and has a row."""
        rows = self.table.rows[self.table.find(index)]
        return {name: rows[name].astype(np.int64) for name in ("hits", "passes")}

    def sightings(self) -> Sightings:
        """All cells that were hit or passed."""
        rows = in_order(self.table.used)
        index, hits, passes = (rows[n].astype(np.int64) for n in ("index", "hits", "passes"))
        return Sightings(index=index, hits=hits, passes=passes)

    def _add_rows(self, rows: Rows) -> None:
        stop = 0
        while stop < len(rows):
            stop, self.table.num_rows = merge_cells(rows, self.table.arrays, stop)
            if stop < len(rows):
                self.table.grow()
