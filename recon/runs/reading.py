"""A run read again from its folder."""

from pathlib import Path

from recon.errors import InputError
from recon.records import Reconstruction, Trajectory
from recon.records.objects import from_json
from recon.runs.report import read_json
from recon.settings import Settings, read_toml, updated
from recon.voxelmap import VoxelMap
from recon.voxelmap.occupancy import occupied


def read_settings(run_path: Path) -> Settings:
    """The settings that a run used."""
    path = run_path / "settings.toml"
    return updated(Settings(), read_toml(path), str(path))


def read_reconstruction(run_path: Path) -> Reconstruction[VoxelMap]:
    """Map, objects and trajectory of a run folder.

    Raises
    ------
    InputError
        Where the folder holds no map, or a file is damaged.
    """
    if not (run_path / "map.npz").exists():
        raise InputError(f"{run_path} holds no map.npz: its figures are drawn when it is made only")
    voxel_map = VoxelMap.load(run_path / "map.npz")
    trajectory_path = run_path / "trajectory.txt"
    return Reconstruction(
        map=voxel_map,
        voxels=occupied(voxel_map, read_settings(run_path).map),
        objects=from_json(read_json(run_path / "objects.json")),
        trajectory=Trajectory.from_tum(trajectory_path.read_text("utf-8"), str(trajectory_path)),
    )
