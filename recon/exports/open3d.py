"""Conversion of points and cells to and from Open3D objects."""

from typing import Any

import numpy as np

from recon.exports.columns import RGB, XYZ, Columns, columns_of, from_columns
from recon.libraries import load_open3d
from recon.records import PointCloud, Voxels


def as_point_cloud(data: PointCloud | Voxels) -> Any:
    """An `open3d.t.geometry.PointCloud` of points or cell means, with every value as attribute."""
    return cloud_of(columns_of(data))


def of_point_cloud(cloud: Any) -> PointCloud | Voxels:
    """Points, or the cells of `as_point_cloud`, from an `open3d.t.geometry.PointCloud`."""
    return from_columns(columns_in(cloud))


def as_voxel_grid(voxels: Voxels) -> Any:
    """An `open3d.geometry.VoxelGrid` of the same cells; it keeps index and colour only."""
    o3d = load_open3d()
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(voxels.centres))
    if voxels.colours is not None:
        cloud.colors = o3d.utility.Vector3dVector(voxels.colours / 255.0)
    span = voxels.index if len(voxels) else np.zeros((1, 3), np.int64)
    corners = (span.min(axis=0) * voxels.cell_size, (span.max(axis=0) + 1) * voxels.cell_size)
    return o3d.geometry.VoxelGrid.create_from_point_cloud_within_bounds(
        cloud, voxels.cell_size, *corners
    )


def of_voxel_grid(grid: Any) -> Voxels:
    """The cells of an `open3d.geometry.VoxelGrid`, each with count 1 and its centre as mean.

    A grid that is not anchored at 0 is shifted by less than half a cell.
    """
    from recon.voxelmap.table import order_of

    low = np.rint(np.asarray(grid.origin) / grid.voxel_size).astype(np.int64)
    cells = grid.get_voxels()
    index = low + np.array([cell.grid_index for cell in cells], np.int64).reshape(-1, 3)
    colours = np.array([cell.color for cell in cells]).reshape(-1, 3)
    rgb = np.rint(255.0 * colours).astype(np.uint8) if grid.has_colors() else None
    return Voxels.occupied(index, float(grid.voxel_size), rgb).select(order_of(index))


def cloud_of(columns: Columns) -> Any:
    """An `open3d.t.geometry.PointCloud` whose attributes are the columns."""
    o3d = load_open3d()
    cloud = o3d.t.geometry.PointCloud()
    for field, names in (("positions", XYZ), ("colors", RGB)):
        if not set(names) <= columns.keys():
            continue
        cloud.point[field] = o3d.core.Tensor(np.column_stack([columns[n] for n in names]))
    for name, values in columns.items():
        if name not in XYZ + RGB:
            cloud.point[name] = o3d.core.Tensor(np.ascontiguousarray(values)[:, None])
    return cloud


def columns_in(cloud: Any) -> Columns:
    """The attributes of an `open3d.t.geometry.PointCloud`; none if it has no positions."""
    columns: Columns = {}
    for field, names in (("positions", XYZ), ("colors", RGB)):
        if field in cloud.point:
            columns |= zip(names, cloud.point[field].numpy().T, strict=True)
    for name, values in cloud.point.items():
        if name not in ("positions", "colors") and values.shape[1] == 1:
            columns[name] = values.numpy()[:, 0]
    return columns
