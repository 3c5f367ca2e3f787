"""The result of all pairs together."""

from dataclasses import dataclass
from typing import Any, Generic

from typing_extensions import TypeVar

from recon.records.clouds import Voxels
from recon.records.objects import FoundObject
from recon.records.trajectory import Trajectory

Map = TypeVar("Map", default=Any)
"""The voxel map, which a higher package defines."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Reconstruction(Generic[Map]):
    """A map, the objects found in it and the trajectory; figures are drawn from these."""

    map: Map
    """All cells, the `VoxelMap`."""
    voxels: Voxels
    """Its occupied cells, by the criteria of the settings."""
    objects: tuple[FoundObject, ...]
    trajectory: Trajectory

    def __repr__(self) -> str:
        labels = ", ".join(found.label for found in self.objects) or "none"
        return (
            f"Reconstruction({len(self.voxels)} occupied cells of {self.voxels.cell_size:g}, "
            f"{len(self.trajectory)} poses, objects: {labels})"
        )
