"""Obstacles as patches of the map, and who has seen them."""

import numpy as np
import pytest

from recon.exploration.floor import Floor
from recon.exploration.obstacles import (
    MIN_POINTS_OF_VIEW,
    Observations,
    columns,
    find_obstacles,
    patches,
)
from recon.records import PointCloud
from recon.voxelmap import VoxelMap


def cloud(points):
    points = np.asarray(points, dtype=np.float64)
    return PointCloud(points=points, colours=np.zeros(points.shape, dtype=np.uint8))


def pillar(x, z, height=12):
    """A point in the middle of every cell of a pillar of 3 x 3 cells."""
    cells = np.stack(np.meshgrid([-1, 0, 1], np.arange(1, height), [-1, 0, 1]), axis=-1)
    return cells.reshape(-1, 3) + np.array([x + 0.5, 0.5, z + 0.5])


def obstacles_of(points, places=(), min_voxels=12, cell_size=1.0):
    voxel_map = VoxelMap(cell_size)
    voxel_map.insert(cloud(points))
    floor, observations = Floor(size_x=100, size_z=100), Observations()
    for place in places:
        observations.add(np.array(place), cloud(points), floor)
    return find_obstacles(voxel_map.occupied(1), floor, observations, min_voxels)


@pytest.mark.parametrize(("gap", "number"), [(1, 1), (2, 2)])
def test_a_gap_of_one_cell_is_closed_and_of_two_is_not(gap, number):
    occupied = np.zeros((20, 20), dtype=bool)
    occupied[5:7, 5:7] = occupied[7 + gap : 9 + gap, 5:7] = True
    patch = patches(occupied)
    assert patch.max() + 1 == number
    assert ((patch >= 0) == occupied).all()


def test_two_pillars_are_two_things_where_they_stand():
    obstacles = obstacles_of(np.vstack([pillar(10, 5), pillar(-20, -7)]))
    assert [obstacle.centre.tolist() for obstacle in obstacles] == [[-19.5, -6.5], [10.5, 5.5]]
    for obstacle in obstacles:
        assert 1.5 < obstacle.radius < 2.2
        assert 11.0 <= obstacle.top < 12.0
        assert len(obstacle.voxels) == 99
        assert len(obstacle.cells) == 9


def test_few_cells_are_no_thing():
    assert len(obstacles_of(pillar(10, 5), min_voxels=99)) == 1
    assert obstacles_of(pillar(10, 5), min_voxels=100) == ()
    assert obstacles_of(pillar(200, 5)) == ()


def test_bearings_are_of_the_places_that_saw_enough():
    assert len(pillar(10, 5)) >= MIN_POINTS_OF_VIEW
    (obstacle,) = obstacles_of(pillar(10, 5), places=[(30.5, 5.5), (10.5, -20.0)])
    assert obstacle.bearings_rad == pytest.approx([0.0, -np.pi / 2])
    floor, observations = Floor(size_x=100, size_z=100), Observations()
    observations.add(np.array([30.5, 5.5]), cloud(pillar(10, 5)[: MIN_POINTS_OF_VIEW - 1]), floor)
    voxel_map = VoxelMap(1.0)
    voxel_map.insert(cloud(pillar(10, 5)))
    (obstacle,) = find_obstacles(voxel_map.occupied(1), floor, observations, 12)
    assert len(obstacle.bearings_rad) == 0


def test_only_what_has_changed_is_worked_out_anew():
    voxel_map, floor, observations = VoxelMap(1.0), Floor(size_x=100, size_z=100), Observations()
    voxel_map.insert(cloud(np.vstack([pillar(10, 5), pillar(-20, -7)])))
    before = find_obstacles(voxel_map.occupied(1), floor, observations, 12)
    voxel_map.insert(cloud(pillar(10, 5)[:1]))
    observations.add(np.array([-20.0, 20.0]), cloud(pillar(-20, -7)), floor)
    kept, grown = find_obstacles(voxel_map.occupied(1), floor, observations, 12, before)
    assert kept.voxels is before[0].voxels
    assert kept.bearings_rad == pytest.approx([np.arctan2(26.5, -0.5)])
    assert grown.voxels is not before[1].voxels
    assert grown.voxels.counts.sum() == before[1].voxels.counts.sum() + 1


@pytest.mark.parametrize("cell_size", [0.5, 1.0, 2.5])
def test_cells_of_any_size_cover_their_floor(cell_size):
    voxel_map = VoxelMap(cell_size)
    x = np.arange(0.1, 20.0, 0.2)
    voxel_map.insert(cloud(np.column_stack([x, np.full(100, 3.0), np.full(100, 0.4)])))
    floor = Floor(size_x=60, size_z=60)
    covered = floor.mask(columns(voxel_map.occupied(1), 1.0))
    assert covered[30:50, 30].all()
    assert 20 <= covered.sum() <= 20 * np.ceil(cell_size) + 3
