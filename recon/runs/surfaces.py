"""Surfaces in runs: every pixel of every pair is matched, fused and written."""

from typing import Any

import numpy as np

from recon.exports.formats import write
from recon.figures.depth import kept_depth
from recon.records import StereoPair
from recon.runs.figures import leave_figure, leave_mesh_figure
from recon.runs.work import Work
from recon.sequences.writing import write_depth
from recon.settings import Settings
from recon.stereo.dense.dense import match_every_pixel
from recon.surface.depth import DepthMap
from recon.surface.fusion import Fusion


class SurfaceWork:
    """The surface of a run, pair by pair; does nothing unless enabled by the settings.

    Parameters
    ----------
    settings : Settings
    work : Work
    unit : str
        Unit of lengths.
    """

    def __init__(self, settings: Settings, work: Work, unit: str = "world units") -> None:
        self.settings = settings
        self.unit = unit
        self.work = work
        self.is_wanted = wants_surface(settings)
        self.fusion = Fusion(settings.surface)
        self._places: list[np.ndarray] = []
        self._fullest: DepthMap | None = None

    def take(self, pair: StereoPair) -> None:
        """Match every pixel of the next pair, and fuse it."""
        if not self.is_wanted:
            return
        with self.work.stage("dense"):
            found = match_every_pixel(pair.left, pair.right, self.settings, pair.disparity_range)
        with self.work.stage("surface"):
            view = self.fusion.add(pair, found)
        if self.settings.surface.depth_maps:
            with self.work.stage("write"):
                write_depth(self.work.run.path / "depth", f"{len(self._places):06d}", view.depth)
        self._places.append(view.position)
        if self._fullest is None or view.valid_mask.sum() > self._fullest.valid_mask.sum():
            self._fullest = view

    def finish(self) -> dict[str, Any]:
        """Write dense.ply and mesh.ply, and return their metrics."""
        if not self.is_wanted:
            return {}
        with self.work.stage("surface"):
            surface = self.fusion.finish()
        folder = self.work.run.path
        with self.work.stage("write"):
            write(surface.cloud, folder / "dense.ply")
            if surface.mesh is not None:
                write(surface.mesh, folder / "mesh.ply")
        with self.work.stage("figures"):
            if self._fullest is not None:
                kept = kept_depth(self._fullest.colours, self._fullest.depth, self.unit)
                leave_figure(folder, "depth", kept)
            if surface.mesh is not None:
                leave_mesh_figure(folder, surface.mesh, np.array(self._places))
        return surface.metrics


def wants_surface(settings: Settings) -> bool:
    """True if a run writes more than its sparse cloud."""
    asked = settings.surface
    return settings.dense.enabled or asked.mesh or asked.watertight or asked.depth_maps
