"""Cells and points to objects of Open3D and pyvista, and back."""

import numpy as np
import pytest

from recon.exports import (
    as_image,
    as_point_cloud,
    as_voxel_grid,
    of_image,
    of_point_cloud,
    of_voxel_grid,
)
from recon.voxelmap import VoxelMap
from tests.exports.maps import CHANNELS, same, sample_cloud, sample_map


def test_voxel_grid_has_the_same_cells_and_colours():
    voxels = sample_map(()).occupied(2)
    grid = as_voxel_grid(voxels)
    assert grid.voxel_size == 0.5
    assert len(grid.get_voxels()) == len(voxels)
    assert np.asarray(grid.check_if_included(_points(voxels.means))).all()
    again = of_voxel_grid(grid)
    assert np.array_equal(again.index, voxels.index)
    assert np.array_equal(again.colours, voxels.colours)
    assert np.array_equal(again.centres, voxels.centres)


def _points(points):
    from recon.libraries import load_open3d

    return load_open3d().utility.Vector3dVector(points)


def test_voxel_grid_of_open3d_is_read():
    from recon.libraries import load_open3d

    o3d = load_open3d()
    cloud = o3d.geometry.PointCloud(_points(np.array([[0.2, 0.2, 0.2], [3.4, 0.2, -1.9]])))
    grid = o3d.geometry.VoxelGrid.create_from_point_cloud_within_bounds(
        cloud, 0.5, np.array([-1.0, -1.0, -2.0]), np.array([4.0, 4.0, 4.0])
    )
    assert of_voxel_grid(grid).index.tolist() == [[0, 0, 0], [6, 0, -4]]


@pytest.mark.parametrize("data", [sample_cloud(), sample_map(CHANNELS).occupied(1)])
def test_point_cloud_keeps_every_value(data):
    same(of_point_cloud(as_point_cloud(data)), data)


def test_image_data_keeps_every_value():
    voxels = sample_map().occupied(2)
    image = as_image(voxels)
    assert image.n_cells >= len(voxels)
    assert image.spacing == (0.5, 0.5, 0.5)
    same(of_image(image), voxels)


def test_image_data_has_the_world_positions_of_the_cells():
    voxels = sample_map().occupied(2)
    image = as_image(voxels)
    found = image.find_containing_cell(voxels.means)
    assert np.array_equal(image.cell_data["counts"][found], voxels.counts)


def test_empty_maps_and_clouds_are_converted():
    voxels = VoxelMap(0.5).occupied()
    assert len(of_voxel_grid(as_voxel_grid(voxels))) == 0
    assert len(of_image(as_image(voxels))) == 0
    assert len(VoxelMap(0.5).to_open3d().points) == 0
    assert VoxelMap(0.5).to_pyvista().n_points == 0


def test_maps_become_points_of_other_libraries():
    voxel_map = sample_map()
    voxels = voxel_map.occupied(2)
    assert np.array_equal(np.asarray(voxel_map.to_open3d(min_count=2).points), voxels.means)
    cells = voxel_map.to_pyvista(min_count=2)
    assert np.array_equal(cells.points, voxels.centres)
    assert np.array_equal(cells["counts"], voxels.counts)
