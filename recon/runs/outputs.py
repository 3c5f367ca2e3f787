"""Files that every run with a map writes besides its figures."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from recon.exports.ply import CloudWriter, read_cloud_chunks
from recon.geometry import Array, invert
from recon.localisation.keeper import PlaceKeeper
from recon.mapping.views import CellCounts, count_cells
from recon.records import PointCloud, Recognition, Reconstruction, Trajectory
from recon.records.objects import as_json
from recon.runfolder import RunFolder
from recon.runs.maps import WHOLE
from recon.runs.work import Work
from recon.voxelmap import VoxelMap


def cells_hit(cloud_path: Path, cell_size: float) -> Iterator[CellCounts]:
    """The cells that the pairs of a cloud file hit, read in chunks."""
    for cloud, pair_number in read_cloud_chunks(cloud_path):
        yield count_cells(cloud, pair_number, cell_size)


def write_outputs(run: RunFolder, reconstruction: Reconstruction, recognition: Recognition) -> None:
    """Write the map unless already written in partitions, the objects and the trajectory."""
    if isinstance(reconstruction.map, VoxelMap):
        reconstruction.map.save(run.path / WHOLE)
    run.write_json("objects.json", as_json(recognition))
    run.write_text("trajectory.txt", reconstruction.trajectory.as_tum())


def move_cloud(path: Path, had: Sequence[Array], trajectory: Trajectory) -> None:
    """Move the points of a cloud file to poses corrected since it was written."""
    now = trajectory.T_world_left
    if all(np.array_equal(old, new) for old, new in zip(had, now, strict=False)):
        return
    with CloudWriter(path) as moved:
        for cloud, pair in clouds_of(path):
            moved.append(cloud.transformed(now[pair] @ invert(had[pair])), pair)


def clouds_of(path: Path) -> Iterator[tuple[PointCloud, int]]:
    """The points of a cloud file, pair by pair; those of one pair may come in two chunks."""
    for cloud, number in read_cloud_chunks(path):
        for pair in np.unique(number):
            yield cloud.select(number == pair), int(pair)


def write_places(work: Work, places: PlaceKeeper, trajectory: Trajectory) -> None:
    """Write the places of the pairs, if there is a run folder."""
    if work.folder is not None:
        with work.stage("write"):
            places.atlas(trajectory).save(work.folder.path / "places.npz")


def as_document(numbers: dict[str, Any]) -> dict[str, Any]:
    """Numbers as JSON values; unknown ones are null."""
    return {name: _plain(value) for name, value in numbers.items()}


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return as_document(value)
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not np.isfinite(value) else value
