"""Depth maps on disk, waiting for corrected poses."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from recon.records import Trajectory
from recon.surface.depth import DepthMap
from recon.voxelmap.archive import read_columns

_IMAGES = "depth", "sigma", "colours"


class WaitingViews:
    """Depth maps in a folder, whose poses may still be corrected.

    Parameters
    ----------
    folder : Path
        Created if needed.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._kept: list[DepthMap] = []

    def keep(self, view: DepthMap) -> None:
        """Write the next view to disk."""
        self.folder.mkdir(parents=True, exist_ok=True)
        with self._path(len(self._kept)).open("wb") as file:
            np.savez(file, depth=view.depth, sigma=view.sigma, colours=view.colours)
        nothing: dict[str, Any] = dict.fromkeys(_IMAGES, np.zeros((0, 0)))
        self._kept.append(replace(view, **nothing))

    def moved_to(self, way: Trajectory) -> Iterator[DepthMap]:
        """Yield the views at the poses of a trajectory."""
        for number, (kept, pose) in enumerate(zip(self._kept, way.T_world_left, strict=True)):
            images: dict[str, Any] = dict(read_columns(self._path(number)))
            yield replace(kept, T_world_left=pose, **images)

    def _path(self, number: int) -> Path:
        return self.folder / f"{number:06d}.npz"
