"""Recognition of clouds, maps and runs from files."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError
from recon.exports import ply
from recon.exports.columns import columns_of
from recon.exports.formats import read
from recon.exports.partitions.partitioned import PartitionedMap
from recon.exports.partitions.store import is_partitioned
from recon.files import check_target
from recon.notices import notify
from recon.recognition.clouds import Up, recognise_cloud
from recon.recognition.recognition import recognise
from recon.records import PointCloud, Recognition, Voxels
from recon.records.objects import as_json
from recon.runs.arguments import flag, one_of, text
from recon.runs.job import Job, Kind, Numbers, Tree
from recon.runs.maps import PARTITIONED, map_path, shown
from recon.runs.reading import read_reconstruction, read_settings
from recon.runs.work import Work
from recon.settings import Settings
from recon.voxelmap import VoxelMap


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Scene:
    """Points or occupied cells to be recognised."""

    data: PointCloud | Voxels
    T_world_left: NDArray[np.float64] | None = None
    """(V, 4, 4) poses of the views, if known."""


def run_of(path: Path) -> Path | None:
    """The run folder of a path or of its map; None if the path does not belong to a run."""
    folder = path if path.is_dir() else path.parent
    if path.name == PARTITIONED:
        folder = path.parent
    own = map_path(folder)
    is_run = (folder / "settings.toml").is_file() and own is not None
    return folder if is_run and path in (folder, own) else None


def read_scene(path: Path, settings: Settings) -> Scene:
    """The points or cells of a cloud, a map, or a run.

    Raises
    ------
    InputError
        If a folder is not a run, or a file cannot be read.
    """
    run = run_of(path)
    if run is not None:
        made = read_reconstruction(run)
        return Scene(data=made.voxels, T_world_left=made.trajectory.T_world_left)
    if path.is_dir() and not is_partitioned(path):
        raise InputError(f"{path} is not a run: a map.npz and a settings.toml are needed")
    data = read(path)
    if isinstance(data, VoxelMap | PartitionedMap):
        data, _ = shown(data, settings.map)
    if data.colours is None:
        notify("colour-missing", f"{path} has no colours: objects are recognised without")
    return Scene(data=data)


def recognise_scene(scene: Scene, settings: Settings, up: Up = "y") -> Recognition:
    """The objects of a scene; a map with another up axis is treated as the cloud of its cells."""
    data = scene.data
    if isinstance(data, Voxels) and up == "y":
        return recognise(data, settings.recognition, scene.T_world_left)
    if isinstance(data, Voxels):
        data = PointCloud(points=data.means, colours=data.colours)
    return recognise_cloud(data, settings.recognition, up)


def _base(job: Job) -> Tree:
    """A run's own settings; for other files no catalogue."""
    (path,) = job.inputs
    run = run_of(path)
    if run is None:
        return {"recognition": {"catalogue": (), "ground": None}}
    settings = read_settings(run)
    return {"map": asdict(settings.map), "recognition": asdict(settings.recognition)}


def _recognise(job: Job, work: Work) -> Numbers:
    """Name the objects of a cloud, a map or a run; the document of `objects.json`."""
    (path,) = job.inputs
    target, up = _target(job.arguments), job.arguments.get("up", "y")
    if up != "y" and run_of(path) is not None:
        raise InputError(f"up is {up!r}, but {path} belongs to a run, whose world has y up")
    scene = read_scene(path, job.settings)
    with work.stage("recognise"):
        found = recognise_scene(scene, job.settings, up)
    if target is not None:
        ply.write(target, columns_of(scene.data) | {"object": found.label})
    return dict(as_json(found))


def _target(arguments: Mapping[str, object]) -> Path | None:
    """The cloud to write."""
    name = arguments.get("cloud")
    if name is None:
        return None
    target = Path(str(name))
    if target.suffix.lower() != ".ply":
        raise InputError(f"-o is {target}, but a name that ends in .ply is needed")
    check_target(target, overwrite=bool(arguments.get("overwrite")))
    return target


RECOGNISE = Kind(
    run=_recognise,
    base=_base,
    takes={"up": one_of("y", "-y", "z", "-z"), "cloud": text, "overwrite": flag},
)
