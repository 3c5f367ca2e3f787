"""The floor: sums over height, and free ground for navigation."""

import pytest

from recon.errors import InputError
from recon.voxelmap import VoxelMap
from recon.voxelmap.ground import FREE, OCCUPIED, UNKNOWN, height_sum, navigation
from tests.voxelmap.clouds import cloud, filled, observed


def test_counts_are_summed_over_height():
    points = cloud([[-2.5, 0, 3.5]] * 2 + [[-2.5, 9, 3.5]] * 3 + [[0.5, 1, 2.5]])
    floor = height_sum(filled(points, cell_size=0.5).occupied(1))
    assert floor.cells.shape == (7, 3)
    assert floor.origin_xz.tolist() == [-2.5, 2.5]
    assert floor.cells.sum() == 6
    assert floor.cells[0, 2] == 5
    assert floor.cells[6, 0] == 1


def test_ground_is_free_where_observed_and_without_obstacles():
    # A wall at x = 5; a branch over the path at height 8; a step below the band.
    points = cloud([[5.5, 1.5, 0.5], [3.5, 8.5, 0.5], [2.5, 0.25, 0.5]])
    voxel_map = observed([(points, [0.5, 1.5, 0.5], 0)], channels=["rays"])
    floor = navigation(voxel_map.occupied(1), voxel_map.sightings(), band=(1.0, 6.0))
    assert floor.cells[:, 0].tolist() == [FREE] * 5 + [OCCUPIED]
    low = navigation(voxel_map.occupied(1), voxel_map.sightings(), band=(0.0, 6.0))
    assert low.cells[:, 0].tolist() == [FREE, FREE, OCCUPIED, FREE, FREE, OCCUPIED]


def test_cell_counts_if_its_centre_lies_in_the_band():
    voxels = filled(cloud([[0.5, 1.1, 0.5], [1.5, 6.1, 0.5], [2.5, 0.9, 0.5]])).occupied(1)
    nothing = VoxelMap(channels=["rays"]).sightings()
    floor = navigation(voxels, nothing, band=(1.2, 6.2))
    assert floor.cells.tolist() == [[OCCUPIED]]
    assert floor.origin_xz.tolist() == [0.0, 0.0]


def test_cells_that_no_ray_crossed_are_unknown():
    points = cloud([[5.5, 1.5, 0.5], [0.5, 1.5, 5.5]])
    voxel_map = observed([(points, [0.5, 1.5, 0.5], 0)], channels=["rays"])
    floor = navigation(voxel_map.occupied(1), voxel_map.sightings())
    assert floor.cells[3, 3] == UNKNOWN
    assert (floor.cells == UNKNOWN).sum() == 25


def test_empty_map_has_no_floor():
    assert height_sum(VoxelMap().occupied(1)).cells.shape == (0, 0)


def test_too_large_floor_is_rejected():
    far = filled(cloud([[-1e6, 0, 0], [1e6, 0, 1e6]]))
    with pytest.raises(InputError, match="the floor has 2000001 x 1000001 cells, but"):
        height_sum(far.occupied(1))


def test_inverted_height_band_is_rejected():
    voxel_map = VoxelMap(channels=["rays"])
    with pytest.raises(InputError, match=r"band is \(6, 1\), but a lower and a higher"):
        navigation(voxel_map.occupied(1), voxel_map.sightings(), band=(6, 1))
