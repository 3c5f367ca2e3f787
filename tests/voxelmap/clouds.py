"""Point clouds shared by the tests of this folder."""

import numpy as np

from recon.records import PointCloud
from recon.voxelmap import VoxelMap

ALL_CHANNELS = ("weight", "views", "rays")


def cloud(points, colours=None, sigma=None):
    points = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    if colours is None:
        colours = np.zeros((len(points), 3), np.uint8)
    return PointCloud(points=points, colours=np.asarray(colours, np.uint8), sigma=sigma)


def random_cloud(rng, num=2000, spread=4.0):
    return cloud(
        rng.normal(scale=spread, size=(num, 3)),
        rng.integers(0, 256, (num, 3)),
        rng.exponential(0.3, num),
    )


def filled(*clouds, cell_size=1.0):
    voxel_map = VoxelMap(cell_size)
    for each in clouds:
        voxel_map.insert(each)
    return voxel_map


def observed(scans, cell_size=1.0, channels=ALL_CHANNELS, ray_margin=0.0):
    """Make a map of scans (cloud, origin, view)."""
    voxel_map = VoxelMap(cell_size, channels=channels, ray_margin=ray_margin)
    for each, origin, view in scans:
        voxel_map.insert(each, origin, view)
    return voxel_map


def random_scans(seed, num_scans=5, num=300):
    rng = np.random.default_rng(seed)
    return [
        (random_cloud(rng, num), rng.normal(scale=3.0, size=3), int(view))
        for view in rng.integers(0, 3, num_scans)
    ]


def saved_bytes(voxel_map, folder, **options):
    path = folder / "map.npz"
    voxel_map.save(path, **options)
    return path.read_bytes()
