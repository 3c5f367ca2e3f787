"""What every run leaves besides its cloud and its figures."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recon.exports.ply import read_cloud_chunks
from recon.records import Recognition, Voxels
from recon.records.objects import as_json
from recon.runfolder import RunFolder
from recon.runs.contents import Trajectory
from recon.voxelmap import VoxelMap

# A pair has seen an object when it put this many points on it (metrics of the run folder).
MIN_POINTS_OF_VIEW = 10


def with_views(recognition: Recognition, voxels: Voxels, cloud_path: Path) -> Recognition:
    """The same objects, with the number of pairs that saw each.

    The cloud is read back in pieces, so that memory is bounded by the map.
    """
    keys = _cell_keys(voxels.index)
    order = np.argsort(keys)
    seen: dict[tuple[int, int], int] = {}
    for cloud, pair_number in read_cloud_chunks(cloud_path):
        index = np.floor(cloud.points / voxels.cell_size).astype(np.int64)
        found = _lookup(keys[order], recognition.label[order], _cell_keys(index))
        pairs, counts = np.unique(
            np.column_stack([found, pair_number])[found >= 0], axis=0, return_counts=True
        )
        for (object_id, number), count in zip(pairs.tolist(), counts.tolist(), strict=True):
            seen[object_id, number] = seen.get((object_id, number), 0) + count
    views = [object_id for (object_id, _), n in seen.items() if n >= MIN_POINTS_OF_VIEW]
    counted = tuple(replace(found, views=views.count(found.id)) for found in recognition.objects)
    return replace(recognition, objects=counted)


def _cell_keys(index: NDArray[np.int64]) -> NDArray[np.int64]:
    shifted = index + (1 << 20)
    keys: NDArray[np.int64] = (shifted[:, 0] << 42) | (shifted[:, 1] << 21) | shifted[:, 2]
    return keys


def _lookup(
    sorted_keys: NDArray[np.int64], values: NDArray[np.int32], keys: NDArray[np.int64]
) -> NDArray[np.int32]:
    if not len(sorted_keys):
        return np.full(len(keys), -1, dtype=np.int32)
    at = np.minimum(np.searchsorted(sorted_keys, keys), len(sorted_keys) - 1)
    return np.where(sorted_keys[at] == keys, values[at], -1).astype(np.int32)


def write_products(
    run: RunFolder, voxel_map: VoxelMap, recognition: Recognition, trajectory: Trajectory
) -> None:
    """Write the map, the objects and the trajectory."""
    voxel_map.save(run.path / "map.npz")
    run.write_json("objects.json", as_json(recognition))
    run.write_text("trajectory.txt", trajectory.as_tum())


def write_metrics(run: RunFolder, metrics: dict[str, Any]) -> None:
    """Write `metrics.json`; a number that is not known is null."""
    run.write_json("metrics.json", as_document(metrics))


def as_document(metrics: dict[str, Any]) -> dict[str, Any]:
    """Metrics as JSON has them: NaN is null."""
    return {name: _plain(value) for name, value in metrics.items()}


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return as_document(value)
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not np.isfinite(value) else value
