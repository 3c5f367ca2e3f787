"""The records of an exploration: its steps and its results."""

from dataclasses import dataclass
from typing import Any

from recon.exploration.floor import Array
from recon.mapping import mapper
from recon.records import FoundObject, Recognition, Reconstruction, Trajectory, View
from recon.voxelmap import VoxelMap

STOP_REASONS = (
    "all known",
    "nothing reachable",
    "limit",
    "controller ended",
    "controller failed",
    "interrupted",
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Step(mapper.Step):
    """One pair of an exploration."""

    view: View
    objects: tuple[FoundObject, ...] = ()
    """Objects recognised so far."""
    said: str = ""
    """The controller's result so far."""
    known_share: float = 0.0
    """Share of the floor that is known, whether free or not."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Exploration:
    """The results of an exploration."""

    reconstruction: Reconstruction[VoxelMap]
    recognition: Recognition
    """Recognition in the reconstruction's voxels."""
    clearest: mapper.Step | None
    """The step with the most matches."""
    views: tuple[View, ...]
    known_free: Array
    """(K, 2) x, z of the centres of the floor cells known to be free."""
    stop_reason: str
    """One of STOP_REASONS."""
    message: str
    """The controller's final message, or the reason for its failure."""
    metrics: dict[str, Any]
    """The numbers of metrics.json except `seconds`; those that need ground truth are None without
    it."""
    true_trajectory: Trajectory | None = None
    """True poses of the pairs; None if motion is exact or the truth is unknown."""

    def __repr__(self) -> str:
        return f"Exploration({len(self.views)} views, {self.stop_reason}, {self.reconstruction})"
