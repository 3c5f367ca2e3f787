"""Surfaces in runs: every pixel of every pair is matched, fused and written."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from recon.errors import InputError
from recon.exports.formats import write_parts
from recon.exports.ply import write_mesh_parts
from recon.figures.depth import kept_depth
from recon.records import StereoPair, Trajectory
from recon.runs.figures import leave_figure, leave_mesh_figure
from recon.runs.job import Numbers
from recon.runs.waiting import WaitingViews
from recon.runs.work import Work
from recon.sequences.open import open_sequence
from recon.sequences.writing import write_depth
from recon.settings import Settings
from recon.stereo.dense.dense import match_every_pixel
from recon.surface.depth import DepthMap, depth_map
from recon.surface.fusion import Fusion, Surface, suggested_voxel

_MOST_DRAWN = 2_000_000
"""Triangles of the figure of a mesh; a larger mesh is drawn coarser, as memory may not hold it."""
SAVED = "surface"
"""Folder with the sums that `recon merge` adds, in runs of chunks."""


class SurfaceWork:
    """The surface of a run, pair by pair; does nothing unless enabled by the settings.

    Parameters
    ----------
    settings : Settings
    work : Work
    waits : bool
        Fuse only after all pairs, as their poses may be corrected.

    Raises
    ------
    InputError
        If only the size of its voxels is set.
    """

    def __init__(self, settings: Settings, work: Work, *, waits: bool = False) -> None:
        self.settings = settings
        self.work = work
        self.is_wanted = settings.wants_surface
        voxel = settings.surface.voxel
        if voxel is not None and not self.is_wanted:
            raise InputError(
                f"surface.voxel is {voxel:g}, but no surface is made: give --dense or --mesh"
            )
        self.fusion = Fusion(settings.surface, work.run.partial / "surface")
        self._waiting = WaitingViews(work.run.partial / "views") if waits else None
        self._places: list[np.ndarray] = []
        self._fullest: DepthMap | None = None

    def take(self, pair: StereoPair, *, counts: bool = True) -> None:
        """Match every pixel of the next pair, and fuse it or only confirm others with it."""
        if not self.is_wanted:
            return
        with self.work.stage("dense"):
            found = match_every_pixel(pair.left, pair.right, self.settings, pair.disparity_range)
        with self.work.stage("surface"):
            view = self.fusion.view_of(pair, found)
            if self._waiting is not None:
                self._waiting.keep(view)
            else:
                self.fusion.add_view(view, counts=counts)
        if counts:
            self._note(view)

    def _note(self, view: DepthMap) -> None:
        if self.settings.surface.depth_maps:
            with self.work.stage("write"):
                write_depth(self.work.run.path / "depth", f"{len(self._places):06d}", view.depth)
        self._places.append(view.position)
        if self._fullest is None or view.valid_mask.sum() > self._fullest.valid_mask.sum():
            self._fullest = view

    def finish(self, way: Trajectory | None = None, *, is_part: bool = False) -> dict[str, Any]:
        """Write dense.ply and mesh.ply, and give their numbers.

        Parameters
        ----------
        way : Trajectory, optional
            Corrected poses of the pairs.
        is_part : bool
            Also write the sums that `recon merge` adds.
        """
        if not self.is_wanted:
            return {}
        with self.work.stage("surface"):
            if self._waiting is not None and way is not None:
                for view in self._waiting.moved_to(way):
                    self.fusion.add_view(view)
                self._places = list(way.positions)
            if is_part:
                self.fusion.save(self.work.run.path / SAVED)
            surface = self.fusion.finish()
        write_surface(surface, self.work)
        with self.work.stage("figures"):
            if self._fullest is not None:
                unit = self.settings.recognition.unit_name
                kept = kept_depth(self._fullest.colours, self._fullest.depth, unit)
                leave_figure(self.work.run.path, "depth", kept)
            _leave_mesh_figure(surface, self.work, np.array(self._places))
        return surface.metrics


def suggested_for(recording: Path, settings: Settings) -> float | None:
    """Voxel size that a run of the whole recording would choose."""
    pair = next(iter(open_sequence(recording, replace(settings.sequence, poses="none"))))
    found = match_every_pixel(pair.left, pair.right, settings, pair.disparity_range)
    return suggested_voxel(depth_map(pair, found))


def write_surface(surface: Surface, work: Work) -> None:
    """Write dense.ply and mesh.ply."""
    with work.stage("write"):
        write_parts(surface.parts, surface.num_points, work.run.path / "dense.ply")
        if (mesh := surface.mesh_parts) is not None:
            num = mesh.num_vertices, mesh.num_triangles
            write_mesh_parts(work.run.path / "mesh.ply", mesh, num)


def merge_surfaces(
    runs: Sequence[Path], settings: Settings, way: Trajectory, work: Work
) -> Numbers:
    """Add the surfaces of runs of chunks, and return their metrics.

    Raises
    ------
    InputError
        If only some runs have one.
    """
    has_one = [(run / SAVED).is_dir() for run in runs]
    if not any(has_one):
        return {}
    if not all(has_one):
        without = runs[has_one.index(False)]
        raise InputError(f"{without} holds no {SAVED}, but {runs[has_one.index(True)]} does")
    fusion = Fusion(settings.surface, work.run.partial / "surface")
    with work.stage("surface"):
        for run in runs:
            fusion.merge(run / SAVED)
        surface = fusion.finish()
    write_surface(surface, work)
    with work.stage("figures"):
        _leave_mesh_figure(surface, work, way.positions)
    return surface.metrics


def _leave_mesh_figure(surface: Surface, work: Work, cameras: np.ndarray) -> None:
    if surface.mesh_parts is not None:
        drawn = surface.mesh_parts.coarse(_MOST_DRAWN)
        leave_mesh_figure(work.run.path, drawn, cameras)
