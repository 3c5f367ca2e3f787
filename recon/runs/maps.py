"""The map of a run: one file, or a folder of partitions if built in chunks."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from recon.errors import InputError
from recon.exports.partitions.partitioned import PartitionedMap
from recon.exports.partitions.store import is_partitioned
from recon.exports.partitions.writing import merge_partitions, write_partitions
from recon.notices import notify
from recon.records import Voxels
from recon.settings import MapSettings
from recon.voxelmap import VoxelMap
from recon.voxelmap.occupancy import occupied

if TYPE_CHECKING:
    from recon.mapping.mapper import Mapper
    from recon.runs.work import Work

WHOLE, PARTITIONED = "map.npz", "map.parquet"
MAX_CELLS = 4_000_000
"""Maximum number of occupied cells for recognition and figures; larger maps are coarsened."""

Map = VoxelMap | PartitionedMap


class ChunkedMap:
    """The growing map of a run: saved after every chunk of pairs, and merged at the end.

    Parameters
    ----------
    chunk : int, optional
        Pairs per chunk; if None, all pairs in one file.
    """

    def __init__(self, settings: MapSettings, work: "Work", chunk: int | None) -> None:
        self.settings = settings
        self.work = work
        self.chunk = chunk
        self._parts: list[PartitionedMap] = []

    def take(self, mapper: "Mapper") -> None:
        """Save the map if a chunk is complete."""
        if self.chunk is not None and mapper.num_pairs % self.chunk == 0:
            self._put_aside(mapper)

    def forget(self) -> None:
        """Discard the saved parts: the map contains all points again."""
        self._parts = []

    def finish(self, mapper: "Mapper") -> Map:
        """The map of all pairs; a partitioned map is then on disk."""
        if self.chunk is None:
            return mapper.voxel_map
        self._put_aside(mapper)
        with self.work.stage("write"):
            return merge_partitions(self._parts, self.work.run.path / PARTITIONED)

    def _put_aside(self, mapper: "Mapper") -> None:
        with self.work.stage("write"):
            place = self.work.run.partial / f"{len(self._parts):06d}.parquet"
            part = write_partitions(mapper.release(), place, self.settings.partition_size)
            self._parts.append(part)


def map_path(run_path: Path) -> Path | None:
    """The path of the map in a run folder; None if there is none."""
    for path in (run_path / WHOLE, run_path / PARTITIONED):
        if path.is_file() or is_partitioned(path):
            return path
    return None


def read_map(run_path: Path) -> Map:
    """The map of a run folder.

    Raises
    ------
    InputError
        If there is none, or it is damaged.
    """
    path = map_path(run_path)
    if path is None:
        raise InputError(f"{run_path} has no {WHOLE}: its figures can only be drawn during the run")
    return VoxelMap.load(path) if path.name == WHOLE else PartitionedMap(path)


def shown(voxel_map: Map, settings: MapSettings) -> tuple[Voxels, Any]:
    """The occupied cells by the rules of the settings, and their map.

    The cells of a too large partitioned map are coarsened with a notice, without a map.
    """
    if isinstance(voxel_map, VoxelMap):
        return occupied(voxel_map, settings), voxel_map
    found = voxel_map.fitting(lambda one: occupied(one, settings), MAX_CELLS)
    if found.factor == 1:
        return found.voxels, voxel_map
    notify(
        "map-coarsened",
        f"{voxel_map.place} has {found.num_chosen} occupied cells of {voxel_map.cell_size:g}: "
        f"they are coarsened to {len(found.voxels)} of {found.voxels.cell_size:g}, as at most "
        f"{MAX_CELLS} are recognised and drawn",
    )
    return found.voxels, None
