"""Exhibits of `recon inspect`: a run folder, or points, cells or a mesh in a file."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from recon.app.layers import Data, Layer, layer_of
from recon.errors import InputError
from recon.exports.formats import holds_mesh, read, read_mesh
from recon.exports.partitions.partitioned import PartitionedMap
from recon.exports.partitions.store import is_partitioned
from recon.exports.ply import read_cloud_chunks
from recon.figures.partition import owners
from recon.manifest import MANIFEST
from recon.notices import collected_notices
from recon.records import FoundObject, PointCloud, Trajectory
from recon.runs.maps import map_path, shown
from recon.runs.reading import is_recorded, read_reconstruction, unit_of_run
from recon.settings import MapSettings
from recon.voxelmap import VoxelMap

CLOUDS = {"dense": "dense.ply", "mesh": "mesh.ply"}
"""Files that a run may have besides its map and its cloud, by layer name."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Exhibit:
    """A file or a run, loaded completely."""

    path: Path
    layers: Mapping[str, Layer]
    objects: tuple[FoundObject, ...] = ()
    trajectory: Trajectory | None = None
    is_run: bool = False
    is_recorded: bool = False
    """True for a run of a real recording."""
    unit: str = ""
    """Unit of lengths, if known."""
    notices: tuple[str, ...] = ()
    """Notices about it, as on the command line."""

    @property
    def figures(self) -> tuple[Path, ...]:
        """The figures of the run."""
        return tuple(sorted((self.path / "figures").glob("*.png"))) if self.is_run else ()


def open_exhibit(path: Path) -> Exhibit:
    """Read a file or a run.

    Raises
    ------
    InputError
        If it does not exist or cannot be shown.
    """
    if not path.exists():
        raise InputError(f"{path} does not exist")
    if (path / MANIFEST).exists():
        with collected_notices() as notices:
            exhibit = _open_run(path)
        return replace(exhibit, notices=tuple(notice.text for notice in notices))
    if path.is_dir() and path.suffix != ".zarr" and not is_partitioned(path):
        raise InputError(f"{path} is not a run folder: it has no {MANIFEST}")
    return Exhibit(path=path, layers={path.name: layer_of(_read(path))})


def _read(path: Path) -> Data:
    """Triangles if a file contains any; else its cells or points."""
    if holds_mesh(path):
        return read_mesh(path)
    data = read(path)
    if isinstance(data, VoxelMap | PartitionedMap):
        return shown(data, MapSettings(min_count=1))[0]
    return data


def _open_run(path: Path) -> Exhibit:
    layers: dict[str, Layer] = {}
    objects: tuple[FoundObject, ...] = ()
    trajectory = None
    if map_path(path) is not None:
        run = read_reconstruction(path)
        objects, trajectory = run.objects, run.trajectory
        owner = owners(run.voxels.means, objects, run.voxels.cell_size)
        layers["map"] = layer_of(run.voxels, {"object": owner})
    if (path / "cloud.ply").exists():
        layers["cloud"] = _run_cloud(path / "cloud.ply")
    for name, file in CLOUDS.items():
        if (path / file).exists():
            layers[name] = layer_of(_read(path / file))
    return Exhibit(
        path=path,
        layers=layers,
        objects=objects,
        trajectory=trajectory,
        is_run=True,
        is_recorded=is_recorded(path),
        unit=unit_of_run(path),
    )


def _run_cloud(path: Path) -> Layer:
    """The cloud of a run, with the pair number of each point."""
    chunks = list(read_cloud_chunks(path))
    if not chunks:
        return layer_of(PointCloud(points=np.empty((0, 3)), colours=np.empty((0, 3), np.uint8)))
    clouds, pairs = zip(*chunks, strict=True)
    sigmas = [np.full(len(one), np.nan) if one.sigma is None else one.sigma for one in clouds]
    cloud = PointCloud(
        points=np.vstack([one.points for one in clouds]),
        colours=np.vstack([one.colours for one in clouds]),
        sigma=np.concatenate(sigmas),
    )
    return layer_of(cloud, {"pair": np.concatenate(pairs).astype(np.float64)})
