"""A run read again from its folder."""

from pathlib import Path

from recon.errors import InputError
from recon.files.documents import read_text
from recon.notices import notify
from recon.records import Reconstruction, Trajectory
from recon.records.objects import from_json
from recon.runs.maps import read_map, shown
from recon.runs.report import read_json
from recon.settings import Settings, read_toml, tolerated, updated


def read_settings(run_path: Path) -> Settings:
    """The settings that a run used; those of an older recon are left out where they are unknown."""
    path = run_path / "settings.toml"
    tree = read_toml(path)
    try:
        return updated(Settings(), tree, str(path))
    except InputError:
        settings, ignored = tolerated(tree)
        notify("settings-ignored", f"{path}: not known to this recon: {', '.join(ignored)}")
        return settings


def read_reconstruction(run_path: Path) -> Reconstruction:
    """Map, objects and trajectory of a run folder; of a map too large, a coarser form.

    Raises
    ------
    InputError
        Where the folder holds no map, or a file is damaged.
    """
    found = read_map(run_path)
    voxels, voxel_map = shown(found, read_settings(run_path).map)
    return Reconstruction(
        map=voxel_map,
        voxels=voxels,
        objects=from_json(read_json(run_path / "objects.json")),
        trajectory=read_trajectory(run_path),
    )


def read_trajectory(run_path: Path) -> Trajectory:
    """The poses of a run."""
    path = run_path / "trajectory.txt"
    return Trajectory.from_tum(read_text(path), str(path))
