"""What the figures of a run are made of, whether it has just ended or is read again."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from recon.errors import InputError
from recon.geometry import pose
from recon.records import FoundObject, Voxels
from recon.records.objects import from_json
from recon.runs.report import read_json
from recon.settings import Settings, read_toml, updated
from recon.voxelmap import VoxelMap
from recon.voxelmap.occupancy import occupied

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Trajectory:
    """Where the left camera was, one row a pair, in order."""

    stamps_s: Array
    """(N,)"""
    T_world_left: Array
    """(N, 4, 4)"""

    @property
    def positions(self) -> Array:
        """(N, 3) in the world."""
        positions: Array = self.T_world_left[:, :3, 3]
        return positions

    def as_tum(self) -> str:
        """The text of `trajectory.txt`: stamp tx ty tz qx qy qz qw."""
        quaternions = Rotation.from_matrix(self.T_world_left[:, :3, :3]).as_quat()
        rows = np.column_stack([self.stamps_s, self.positions, quaternions])
        return "".join(" ".join(f"{value:.9f}" for value in row) + "\n" for row in rows)


def read_tum(path: Path) -> Trajectory:
    """The trajectory of a run.

    Raises
    ------
    InputError
        Where a row has not its eight numbers.
    """
    try:
        rows = np.loadtxt(path, ndmin=2)
    except ValueError as error:
        raise InputError(f"{path}: {error}, but eight numbers a row are needed") from error
    rows = rows.reshape(-1, 8) if not rows.size else rows
    if rows.shape[1] != 8:
        raise InputError(f"{path}: {rows.shape[1]} numbers a row, but eight are needed")
    rotations = Rotation.from_quat(rows[:, 4:]).as_matrix() if len(rows) else np.empty((0, 3, 3))
    poses = [pose(*row) for row in zip(rotations, rows[:, 1:4], strict=True)]
    return Trajectory(stamps_s=rows[:, 0], T_world_left=np.array(poses).reshape(-1, 4, 4))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RunContents:
    """The map, what was found in it, and the way there."""

    voxels: Voxels
    objects: tuple[FoundObject, ...]
    trajectory: Trajectory


def read_contents(run_path: Path) -> RunContents:
    """Read map, objects and trajectory of a run folder."""
    if not (run_path / "map.npz").exists():
        raise InputError(f"{run_path} holds no map.npz: its figures are drawn when it is made only")
    settings_path = run_path / "settings.toml"
    settings = updated(Settings(), read_toml(settings_path), str(settings_path))
    return RunContents(
        voxels=occupied(VoxelMap.load(run_path / "map.npz"), settings.map),
        objects=from_json(read_json(run_path / "objects.json")),
        trajectory=read_tum(run_path / "trajectory.txt"),
    )
