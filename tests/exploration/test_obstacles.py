"""Obstacles as patches of the map, and the bearings they were seen from."""

import numpy as np
import pytest

from recon.camera import StereoRig
from recon.exploration.columns import Columns
from recon.exploration.floor import Floor
from recon.exploration.obstacles import (
    MIN_POINTS_OF_VIEW,
    Observations,
    UpperEdge,
    find_obstacles,
    patches,
)
from recon.geometry import look_at
from recon.records import PointCloud, StereoPair
from recon.settings import MapSettings
from recon.voxelmap.occupancy import new_map

HIGH = UpperEdge(height=5.0, slope=10.0)


def cloud(points):
    points = np.asarray(points, dtype=np.float64)
    return PointCloud(points=points, colours=np.zeros(points.shape, dtype=np.uint8))


def pillar(x, z, height=12):
    """Make a point at the centre of every cell of a 3 x 3 pillar."""
    cells = np.stack(np.meshgrid([-1, 0, 1], np.arange(1, height), [-1, 0, 1]), axis=-1)
    return cells.reshape(-1, 3) + np.array([x + 0.5, 0.5, z + 0.5])


def columns_of(points, cell_size=1.0, **settings):
    chosen = MapSettings(cell_size=cell_size, min_count=1, **settings)
    floor = Floor(size_x=100, size_z=100, cell_size=cell_size)
    columns = Columns(voxel_map=new_map(chosen), settings=chosen, floor=floor, ground=0.0)
    added(columns, points)
    return columns


def added(columns, points):
    """Insert points into the map of some columns; return the cells that may have changed."""
    columns.voxel_map.insert(cloud(points), origin=(0.0, 40.0, 0.0))
    return columns.update(points)


def obstacles_of(points, places=(), min_voxels=12):
    columns, observations = columns_of(points), Observations()
    for place in places:
        observations.add(np.array(place), cloud(points), columns.floor, HIGH)
    return find_obstacles(columns, observations, min_voxels)


@pytest.mark.parametrize(("gap", "number"), [(1, 1), (2, 2)])
def test_gap_of_one_cell_is_closed_but_not_of_two(gap, number):
    occupied = np.zeros((20, 20), dtype=bool)
    occupied[5:7, 5:7] = occupied[7 + gap : 9 + gap, 5:7] = True
    patch = patches(occupied)
    assert patch.max() + 1 == number
    assert ((patch >= 0) == occupied).all()


def test_two_pillars_are_two_obstacles_at_their_positions():
    obstacles = obstacles_of(np.vstack([pillar(10, 5), pillar(-20, -7)]))
    assert [obstacle.centre.tolist() for obstacle in obstacles] == [[-19.5, -6.5], [10.5, 5.5]]
    for obstacle in obstacles:
        assert 1.5 < obstacle.radius < 2.2
        assert 11.0 <= obstacle.top < 12.0
        assert len(obstacle.voxels) == 99
        assert len(obstacle.cells) == 9


def test_few_cells_are_not_an_obstacle():
    assert len(obstacles_of(pillar(10, 5), min_voxels=99)) == 1
    assert obstacles_of(pillar(10, 5), min_voxels=100) == ()
    assert obstacles_of(pillar(200, 5)) == ()


def test_bearings_are_those_of_views_with_enough_points():
    assert len(pillar(10, 5)) >= MIN_POINTS_OF_VIEW
    (obstacle,) = obstacles_of(pillar(10, 5), places=[(30.5, 5.5), (10.5, -20.0)])
    assert obstacle.bearings_rad == pytest.approx([0.0, -np.pi / 2])
    columns, observations = columns_of(pillar(10, 5)), Observations()
    few = cloud(pillar(10, 5)[: MIN_POINTS_OF_VIEW - 1])
    observations.add(np.array([30.5, 5.5]), few, columns.floor, HIGH)
    (obstacle,) = find_obstacles(columns, observations, 12)
    assert len(obstacle.bearings_rad) == 0


def test_views_from_too_near_cut_off_the_top():
    """The top of the pillar is at 11.5; half a radius before it, the edges are at 12.7 and 5.9."""
    columns, observations = columns_of(pillar(10, 5)), Observations()
    for x in (20.5, 12.5):
        place, edge = np.array([x, 5.5]), UpperEdge(height=5.0, slope=0.85)
        observations.add(place, cloud(pillar(10, 5)), columns.floor, edge)
    (obstacle,) = find_obstacles(columns, observations, 12)
    assert obstacle.bearings_rad.tolist() == [0.0, 0.0]
    assert obstacle.is_whole.tolist() == [True, False]


@pytest.mark.parametrize(("up", "slope"), [(0.0, 0.5), (1.0, 3.0)])
def test_upper_edge_rises_with_the_gaze(up, slope):
    """Half the height is half the focal length; a gaze up by 45 degrees rises by (1 + .5) / .5."""
    rig = StereoRig(
        width=100, height=101, focal_px=100.0, cx_left_px=50.0, cx_right_px=50.0, cy_px=50.0,
        baseline=0.1,
    )  # fmt: skip
    image = np.zeros((101, 100), np.uint8)
    T = look_at(np.array([1.0, 4.0, 2.0]), np.array([1.0, 4.0 + up, 1.0]))
    pair = StereoPair(left=image, right=image, rig=rig, name="", T_world_left=T)
    edge = UpperEdge.of(pair)
    assert edge.height == 4.0
    assert edge.slope == pytest.approx(slope)


def test_only_changed_obstacles_are_recomputed():
    columns, observations = columns_of(np.vstack([pillar(10, 5), pillar(-20, -7)])), Observations()
    before = find_obstacles(columns, observations, 12)
    observations.add(np.array([10.5, 20.0]), cloud(pillar(10, 5)), columns.floor, HIGH)
    touched = added(columns, pillar(10, 5)[:1])
    kept, grown = find_obstacles(columns, observations, 12, before, touched)
    assert kept is before[0]
    assert grown.bearings_rad == pytest.approx([np.pi / 2])
    assert grown.voxels.counts.sum() == before[1].voxels.counts.sum() + 1
    assert grown.covered is before[1].covered


@pytest.mark.parametrize("occupancy", [("count",), ("count", "carving")])
def test_incremental_update_gives_the_obstacles_of_all_pairs(occupancy):
    rng = np.random.default_rng(4)
    pairs = [pillar(*rng.integers(-40, 40, 2))[: rng.integers(20, 99)] for _ in range(12)]
    columns, observations, found = columns_of(pairs[0], occupancy=occupancy), Observations(), ()
    for points in pairs:
        found = find_obstacles(columns, observations, 12, found, added(columns, points))
    columns.under[:] = False
    columns.under |= columns.floor.mask(columns.over(~columns.under).centres[:, [0, 2]])
    fresh = find_obstacles(columns, observations, 12)
    assert len(found) == len(fresh) > 6
    for one, other in zip(found, fresh, strict=True):
        assert one.cells.tolist() == other.cells.tolist()
        assert one.voxels.counts.tolist() == other.voxels.counts.tolist()


@pytest.mark.parametrize("cell_size", [0.5, 1.0, 2.5])
def test_obstacles_of_any_cell_size_are_above_the_floor(cell_size):
    x = np.arange(0.1, 20.0, 0.2)
    line = np.column_stack([x, np.full(100, 3.0), np.full(100, 0.4)])
    columns = columns_of(line, cell_size)
    assert (columns.under == columns.floor.mask(line[:, [0, 2]])).all()
    assert columns.under.sum() == np.ceil(20.0 / cell_size)
