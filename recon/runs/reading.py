"""Reading of a run from its folder."""

from pathlib import Path

from recon.errors import InputError
from recon.files.documents import read_text, read_toml
from recon.manifest import MANIFEST, input_paths, read_manifest
from recon.notices import notify
from recon.records import Reconstruction, Trajectory
from recon.records.objects import from_json
from recon.runs.maps import read_map, shown
from recon.runs.report import read_json
from recon.settings import Settings, tolerated, updated

RECORDED = ("reconstruct", "merge")
"""Commands with real recordings."""


def read_settings(run_path: Path) -> Settings:
    """The settings of a run; unknown settings of an older recon are ignored.

    Raises
    ------
    InputError
        If the folder is not that of a run, or its settings cannot be read.
    """
    path = run_path / "settings.toml"
    if not path.is_file():
        raise InputError(f"{run_path} is not a run folder: it has no settings.toml")
    tree = read_toml(path)
    try:
        return updated(Settings(), tree, str(path))
    except InputError:
        settings, ignored = tolerated(tree)
        notify("settings-ignored", f"{path}: not known to this recon: {', '.join(ignored)}")
        return settings


def unit_of_run(run_path: Path) -> str:
    """The name of the unit of a run's lengths."""
    return read_settings(run_path).recognition.unit_name


def read_reconstruction(run_path: Path) -> Reconstruction:
    """Map, objects and trajectory of a run folder; a too large map is coarsened.

    Raises
    ------
    InputError
        If the folder has no map, or a file is damaged.
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


def is_recorded(run_path: Path) -> bool:
    """True if a run, or the run whose mesh it is, used a real recording."""
    manifest = read_manifest(run_path)
    sources = input_paths(manifest)
    if manifest["command"] == "mesh" and sources and (sources[0] / MANIFEST).exists():
        return is_recorded(sources[0])
    return bool(manifest["command"] in RECORDED)
