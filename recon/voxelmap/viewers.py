"""Conversion of cells to objects of other libraries, for their viewers and tools."""

from typing import Any

import numpy as np

from recon.libraries import load_open3d, load_pyvista
from recon.records import Voxels


def to_open3d(voxels: Voxels) -> Any:
    """An open3d.geometry.PointCloud: one point per cell, at the mean of its points."""
    o3d = load_open3d()
    cloud = o3d.geometry.PointCloud()
    cloud.points = o3d.utility.Vector3dVector(voxels.means)
    if voxels.colours is not None:
        cloud.colors = o3d.utility.Vector3dVector(voxels.colours / 255.0)
    return cloud


def to_pyvista(voxels: Voxels) -> Any:
    """A pyvista.PolyData: one point per cell at its centre, with `counts` and known `colours`."""
    cells = load_pyvista().PolyData(np.ascontiguousarray(voxels.centres))
    if not len(voxels):  # pyvista refuses arrays without rows
        return cells
    if voxels.colours is not None:
        cells["colours"] = voxels.colours
    cells["counts"] = voxels.counts
    cells["means"] = voxels.means
    return cells
