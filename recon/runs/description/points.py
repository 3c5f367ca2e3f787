"""Descriptions of clouds, maps, meshes and matches."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from recon.errors import InputError
from recon.exports.content import is_in_partitions, is_map
from recon.exports.formats import format_of, holds_mesh, read, read_mesh
from recon.records import PointCloud, Voxels
from recon.runs.description.facts import Facts, extent, spread

if TYPE_CHECKING:  # it imports the kernels of maps
    from recon.exports.partitions.partitioned import PartitionedMap

_MATCHES = ("points_px", "disparity_px", "sigma_px", "score")
_FIELDS = ("weights", "num_views", "hits", "passes")


def of_points(path: Path) -> Facts:
    """A cloud, a map or a mesh, by the content of its file."""
    if holds_mesh(path):
        return _of_mesh(path)
    data = read(path)
    if is_in_partitions(data):
        return _of_partitions(data)
    up = {"up_in_file": format_of(path).up}
    if isinstance(data, PointCloud):
        return {"kind": "cloud", "num_points": len(data)} | up | _of_cloud(data)
    channels = data.channels if is_map(data) else _channels(data)
    voxels = data.occupied(min_count=1) if is_map(data) else data
    return {
        "kind": "map",
        "num_cells": len(voxels),
        "cell_size": voxels.cell_size,
        "num_points": int(voxels.counts.sum()),
        "channels": list(channels),
    } | up | extent(voxels.means)  # fmt: skip


def _of_partitions(data: "PartitionedMap") -> Facts:
    """A partitioned map, from its manifest: no partition is read."""
    side = data.cell_size * data.form.partition_size
    cubes = np.array([entry.index for entry in data.partitions]).reshape(-1, 3)
    return {
        "kind": "map",
        "num_cells": data.num_cells,
        "cell_size": data.cell_size,
        "num_points": data.num_points,
        "channels": list(data.channels),
        "up_in_file": "y",
        "num_partitions": len(data),
        "partition_size": data.form.partition_size,
        "largest_partition": max((entry.num_cells for entry in data.partitions), default=0),
    } | extent(np.concatenate([cubes, cubes + 1]) * side)


def _channels(voxels: Voxels) -> list[str]:
    return [name for name in _FIELDS if getattr(voxels, name) is not None]


def _of_cloud(cloud: PointCloud) -> Facts:
    columns = {name: values.dtype.name for name, values in cloud.attributes.items()}
    facts: Facts = extent(cloud.points) | {
        "has_colour": cloud.colours is not None,
        "has_sigma": cloud.sigma is not None,
        "columns": columns,
    }
    return facts | ({"crs": _name(cloud.crs.records)} if cloud.crs else {})


def _name(records: tuple[tuple[int, bytes], ...]) -> str:
    """The name of a reference system, or the EPSG code of its keys."""
    for number, content in records:
        if number == 2112:
            return (
                content.decode("utf-8", "replace").strip("\0").partition('"')[2].partition('"')[0]
            )
        if number == 34735:
            keys = np.frombuffer(content[: len(content) // 8 * 8], "<u2").reshape(-1, 4)[1:]
            codes = {int(key): int(code) for key, _, _, code in keys}
            code = codes.get(3072, codes.get(2048))
            return f"EPSG:{code}" if code else "GeoTIFF keys"
    return "unnamed"


def _of_mesh(path: Path) -> Facts:
    """A mesh; its vertices count as points, since they are read as points without triangles."""
    mesh = read_mesh(path)
    return {
        "kind": "mesh",
        "num_points": len(mesh.vertices),
        "num_vertices": len(mesh.vertices),
        "num_triangles": len(mesh),
        "area": mesh.area,
        "has_colour": mesh.colours is not None,
        "has_normals": mesh.normals is not None,
    } | extent(mesh.vertices)  # fmt: skip


def of_npz(path: Path) -> Facts:
    """Matches of a pair, or a cloud or map."""
    from recon.voxelmap import archive

    arrays = archive.read_columns(path)
    if not {"points_px", "disparity_px"} <= arrays.keys():
        return of_points(path)
    return of_matches({name: arrays[name] for name in _MATCHES if name in arrays})


def of_matches(arrays: dict[str, Any]) -> Facts:
    """The number of matches, and the range of their values."""
    facts: Facts = {"kind": "matches", "num_matches": len(arrays["disparity_px"])}
    for name in ("disparity_px", "sigma_px", "score"):
        if name in arrays:
            if arrays[name].shape != arrays["disparity_px"].shape:
                raise InputError(f"its {name} has shape {arrays[name].shape}")
            facts |= spread(name, np.asarray(arrays[name], np.float64))
    return facts
