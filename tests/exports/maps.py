"""Clouds and maps shared by the tests of this folder."""

import numpy as np

from recon.records import PointCloud
from recon.voxelmap import VoxelMap

CHANNELS = ("weight", "views", "rays")
CLOUD_FORMATS = [".ply", ".pcd", ".las", ".laz", ".parquet", ".zarr", ".npz"]
CELL_FORMATS = [*CLOUD_FORMATS, ".vti"]
GRID_FORMATS = [".bt", ".ot", ".pgm", ".yaml"]


def sample_cloud(seed=0, num=300, with_sigma=True):
    rng = np.random.default_rng(seed)
    return PointCloud(
        points=rng.normal(scale=5.0, size=(num, 3)) + np.array([100, 2, -40]),
        colours=rng.integers(0, 256, (num, 3)).astype(np.uint8),
        sigma=rng.random(num) if with_sigma else None,
    )


def sample_map(channels=CHANNELS, cell_size=0.5):
    voxel_map = VoxelMap(cell_size, channels=channels)
    for view in range(3):
        voxel_map.insert(sample_cloud(view), [100.0, 2.0, -41.0], view)
    return voxel_map


def same(a, b, tolerance=0.0):
    for name in type(a).__slots__:
        ours, theirs = getattr(a, name), getattr(b, name)
        if ours is None or theirs is None:
            assert ours is theirs, name
        elif isinstance(ours, dict):
            assert sorted(ours) == sorted(theirs), name
            assert all(np.array_equal(ours[key], theirs[key]) for key in ours), name
        else:
            assert np.asarray(ours).dtype == np.asarray(theirs).dtype, name
            assert np.abs(np.subtract(ours, theirs, dtype=float)).max(initial=0) <= tolerance, name
