"""A partitioned voxel map that loads only the partitions needed."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from recon.errors import InputError
from recon.exports.partitions.joined import coarser, joined
from recon.exports.partitions.manifest import Entry, read_manifest
from recon.exports.partitions.rows import from_parquet
from recon.exports.partitions.store import Place, store_of
from recon.files import check_memory
from recon.records import Voxels
from recon.voxelmap import VoxelMap
from recon.voxelmap.rays import Sightings
from recon.voxelmap.summed import map_of, names_of
from recon.voxelmap.sums import CellSums, added, lie_in

Box = tuple[Sequence[float], Sequence[float]]
"""Low and high corner (3,), world."""
Choice = Callable[[VoxelMap], Voxels]
"""The occupied cells of a map."""
BYTES_PER_ROW = 200.0
"""Memory per cell while a map is built."""


class PartitionedMap:
    """A voxel map in a folder: cubes of space, each a file that is read on demand.

    Iteration yields the partitions in the order of their index, each as a separate `VoxelMap`.

    Parameters
    ----------
    place : path or URL
        The output of `write_partitions` or of a reconstruction in chunks.

    Raises
    ------
    InputError
        If the folder does not contain a complete partitioned map.

    Examples
    --------
    >>> city = PartitionedMap("runs/city/map.parquet")  # doctest: +SKIP
    >>> city.occupied(box=((0, 0, 0), (50, 20, 50)))  # doctest: +SKIP
    """

    def __init__(self, place: Place) -> None:
        self.place = place
        self._store = store_of(place)
        manifest = read_manifest(self._store, place)
        self.form = manifest.form
        self.partitions = manifest.partitions

    def __repr__(self) -> str:
        return (
            f"PartitionedMap({self.num_cells} cells of {self.cell_size:g} "
            f"in {len(self)} partitions)"
        )

    def __len__(self) -> int:
        return len(self.partitions)

    def __iter__(self) -> Iterator[VoxelMap]:
        return (self.load(entry) for entry in self.partitions)

    @property
    def cell_size(self) -> float:
        """Side of a cell, world units."""
        return self.form.cell_size

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the data of the cells besides hits, position and colour."""
        return self.form.channels

    @property
    def num_cells(self) -> int:
        """Number of cells with a point."""
        return sum(entry.num_cells for entry in self.partitions)

    @property
    def num_points(self) -> int:
        """Number of points in all cells."""
        return sum(entry.num_points for entry in self.partitions)

    def intersecting(self, box: Box) -> list[Entry]:
        """The partitions that intersect a box."""
        low, high = np.asarray(box, dtype=np.float64)
        side = self.cell_size * self.form.partition_size
        corners = np.array([entry.index for entry in self.partitions]).reshape(-1, 3) * side
        is_met = ((corners <= high) & (corners + side >= low)).all(axis=1)
        return [entry for entry, met in zip(self.partitions, is_met, strict=True) if met]

    def load(self, entry: Entry) -> VoxelMap:
        """One partition as a map."""
        return self._map_of(self.sums(entry))

    def sums(self, entry: Entry) -> CellSums:
        """The cells of one partition.

        Raises
        ------
        InputError
            If its file is missing, damaged, or not the one in the manifest.
        """
        try:
            content = self._store.read(entry.file)
            names = names_of(self.channels, has_colour=self.form.has_colour)
            cells = from_parquet(content, names, keeps_views="views" in self.channels)
        except FileNotFoundError as error:
            raise InputError(f"{self.place}: its {entry.file} is missing") from error
        except InputError as error:
            raise InputError(f"{self.place}, {entry.file}: {error}") from error
        if not self._is_of(cells, entry):
            raise InputError(f"{self.place}: its {entry.file} is not the one of its manifest")
        return cells

    def _is_of(self, cells: CellSums, entry: Entry) -> bool:
        is_inside = lie_in(cells.index, entry.index, self.form.partition_size)
        return is_inside and entry == summary(entry.index, cells)

    def within(self, box: Box) -> VoxelMap:
        """The cells whose centre lies in a box, as a map; only intersecting partitions are read."""
        low, high = box
        return self.whole(self.intersecting(box)).cropped(low, high)

    def whole(self, entries: Sequence[Entry] | None = None) -> VoxelMap:
        """All partitions, or some, as one map in memory.

        Raises
        ------
        InputError
            If it exceeds the memory limit.
        """
        chosen = self.partitions if entries is None else entries
        num_rows = sum(entry.num_rows for entry in chosen)
        check_memory(self.place, BYTES_PER_ROW * num_rows)
        if not chosen:
            return VoxelMap(self.cell_size, channels=self.channels, ray_margin=self.form.ray_margin)
        return self._map_of(added(self.sums(entry) for entry in chosen))

    def _map_of(self, cells: CellSums) -> VoxelMap:
        try:
            return map_of(cells, self.cell_size, self.channels, self.form.ray_margin)
        except InputError as error:
            raise InputError(f"{self.place}: {error}") from error

    def occupied(self, min_count: int = 5, *, box: Box | None = None) -> Voxels:
        """The cells with at least `min_count` points, ordered by x, then y, then z.

        Parameters
        ----------
        box : (low, high), optional
            Only cells whose centre lies inside; only intersecting partitions are read.
        """
        maps = iter(self) if box is None else iter([self.within(box)])
        return joined((one.occupied(min_count) for one in maps), self.cell_size)

    def fitting(self, choice: Choice, max_cells: int) -> "Fitting":
        """The chosen cells of all partitions, coarsened until there are at most `max_cells`."""
        factor, parts, num, most = 1, [], 0, self.form.partition_size
        for voxel_map in self:
            chosen = choice(voxel_map)
            num += len(chosen)
            parts.append(coarser(chosen, factor))
            while sum(map(len, parts)) > max_cells and factor < most:
                factor *= 2
                parts = [coarser(part, 2) for part in parts]
        voxels = joined(parts, factor * self.cell_size)
        return Fitting(voxels=voxels, factor=factor, num_chosen=num)

    def sightings(self) -> Sightings:
        """Every cell that a scan hit or passed, from a map that keeps rays."""
        found = [one.sightings() for one in self]
        columns: dict[str, Any] = {
            name: np.concatenate([getattr(one, name) for one in found])
            for name in Sightings.__slots__
        }
        order = np.lexsort(columns["index"].T[::-1])
        return Sightings(**{name: column[order] for name, column in columns.items()})


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Fitting:
    """Cells of a partitioned map, few enough to be processed at once."""

    voxels: Voxels
    factor: int
    """Size of the cells relative to those of the map; 1 if they fit unchanged."""
    num_chosen: int
    """Number of map cells that they represent."""


def summary(index: tuple[int, int, int], cells: CellSums) -> Entry:
    """The entry of a partition in the manifest."""
    count = cells.sums["count"][cells.index[0] == 0]
    return Entry(
        index=index,
        num_rows=len(cells),
        num_cells=int((count > 0).sum()),
        num_points=int(count.sum()),
    )
