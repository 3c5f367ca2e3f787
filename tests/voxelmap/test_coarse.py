"""Points too uncertain for the cells of a map are counted in coarser cells, and none is lost."""

from dataclasses import replace

import numpy as np
import pytest

from recon.errors import InputError
from recon.records import PointCloud
from recon.voxelmap import VoxelMap
from tests.voxelmap.clouds import saved_bytes


def cloud_of(sigma, rng=None, spread=20.0):
    rng = rng or np.random.default_rng(3)
    sigma = np.asarray(sigma, dtype=np.float64)
    return PointCloud(
        points=rng.uniform(-spread, spread, (len(sigma), 3)),
        colours=rng.integers(0, 256, (len(sigma), 3), dtype=np.uint8),
        sigma=sigma,
    )


def test_points_go_to_the_finest_cells_no_smaller_than_their_sigma():
    voxel_map = VoxelMap(0.5)
    assert voxel_map.insert_doubtful(cloud_of([0.1, 0.9, 1.0, 1.1, 3.9, 31.0])) == 6
    assert [one.cell_size for one in voxel_map.coarse] == [1.0, 2.0, 4.0, 32.0]
    counts = [int(one.occupied(1).counts.sum()) for one in voxel_map.coarse]
    assert counts == [3, 1, 1, 1]
    assert voxel_map.num_cells == 0


def test_points_without_a_usable_sigma_or_position_are_not_counted():
    voxel_map = VoxelMap(0.5)
    cloud = cloud_of([33.0, np.inf, np.nan, 0.2, 0.2])
    points = cloud.points.copy()
    points[3], points[4] = np.nan, 1e12
    assert voxel_map.insert_doubtful(replace(cloud, points=points)) == 0
    assert voxel_map.insert_doubtful(replace(cloud, sigma=None)) == 0
    assert voxel_map.coarse == ()
    with pytest.raises(InputError, match="cloud is of type str"):
        voxel_map.insert_doubtful("points")


def test_coarse_cells_are_saved_merged_and_cropped(tmp_path):
    rng = np.random.default_rng(5)
    parts = [cloud_of(rng.uniform(0.1, 12, 300), rng) for _ in range(2)]
    whole, first, second = VoxelMap(0.5), VoxelMap(0.5), VoxelMap(0.5)
    for part, own in zip(parts, (first, second), strict=True):
        for one in (whole, own):
            one.insert(part.select(slice(0, 40)))
            assert one.insert_doubtful(part.select(slice(40, None))) == 260
    first.merge(second)
    assert saved_bytes(first, tmp_path) == saved_bytes(whole, tmp_path)
    assert saved_bytes(VoxelMap.load(tmp_path / "map.npz"), tmp_path) == saved_bytes(
        whole, tmp_path
    )
    half = whole.cropped([-50, -50, -50], [0, 50, 50])
    for part, one in zip(half.coarse, whole.coarse, strict=True):
        middles = one.occupied(1).centres
        assert part.num_cells == (middles[:, 0] <= 0).sum()
    twice = whole.cropped([-99] * 3, [99] * 3)
    twice.merge(twice)
    assert [v.occupied(1).counts.sum() for v in twice.coarse] == [
        2 * v.occupied(1).counts.sum() for v in whole.coarse
    ]
