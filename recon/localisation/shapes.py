"""Guesses by shape: the poses from which the thing before the cameras may be one of the map.

What is round looks the same from all sides, and the map holds several things; features alone do
not tell how many poses would show the same.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label

from recon.geometry import Array, pose, rotation_about_y
from recon.records import PointCloud, Voxels

NUM_BEARINGS = 36
MAX_SIGMA_CELLS = 3.0
"""Points that are less sure do not make a thing."""
MIN_POINTS, MIN_CELLS = 20, 8
"""Of a thing before the cameras, and of one of the map."""
MAX_THINGS = 60
"""A map of more is not searched by shape: it would take too long, and features tell more there."""
LEVEL_COSINE = 0.966
"""Cameras that tilt or roll more than 15 degrees are not guessed by shape."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Thing:
    """A patch of the ground with something on it."""

    centre: Array
    """(2,) x, z of the middle of its box."""
    radius: float
    """Half the width of its box."""


def things(voxels: Voxels) -> list[Thing]:
    """Things that stand apart on the map, seen from above."""
    found = []
    for rows in _patches(voxels.means[:, [0, 2]], voxels.cell_size):
        if len(rows) >= MIN_CELLS:
            low, high = (f(voxels.means[rows][:, [0, 2]], axis=0) for f in (np.min, np.max))
            found.append(Thing(centre=(low + high) / 2, radius=float((high - low).max()) / 2))
    return found


def guesses(cloud: PointCloud, voxels: Voxels, T_world_left: Array) -> list[Array]:
    """Poses (4, 4), at the height and tilt of one, that put the thing ahead onto things of the map.

    Parameters
    ----------
    cloud : PointCloud
        Points of the pair, left frame.
    voxels : Voxels
    T_world_left : (4, 4) array
        A pose of the same robot, for its height and tilt; where it is not nearly level, no guess.
    """
    of_map = things(voxels)
    ahead = _nearest_thing(cloud, voxels.cell_size)
    if ahead is None or len(of_map) > MAX_THINGS or -T_world_left[1, 1] < LEVEL_COSINE:
        return []
    turned = T_world_left[:3, :3] @ ahead
    bearings = np.linspace(0.0, 2.0 * np.pi, NUM_BEARINGS, endpoint=False)
    return [
        _standing(one, rotation_about_y(float(bearing)), turned, T_world_left)
        for one in of_map
        for bearing in bearings
    ]


def _standing(thing: Thing, turn: Array, offset: Array, T_world_left: Array) -> Array:
    """The pose, turned, whose offset (3,) leads to the near side of a thing."""
    offset = turn @ offset
    x, z = thing.centre - offset[[0, 2]] * (1.0 + thing.radius / np.hypot(offset[0], offset[2]))
    return pose(turn @ T_world_left[:3, :3], [x, T_world_left[1, 3], z])


def _nearest_thing(cloud: PointCloud, cell_size: float) -> Array | None:
    """(3,) the middle of the front of the nearest thing, left frame; None if nothing stands."""
    sigma = np.zeros(len(cloud)) if cloud.sigma is None else cloud.sigma
    points = cloud.points[sigma <= MAX_SIGMA_CELLS * cell_size]
    patches = [points[rows] for rows in _patches(points[:, [0, 2]], cell_size, closing=2.0)]
    large = [patch for patch in patches if len(patch) >= MIN_POINTS]
    if not large:
        return None
    nearest = min(large, key=lambda patch: float(np.median(patch[:, 2])))
    bearing = nearest[:, 0] / nearest[:, 2]
    middle = (np.percentile(bearing, 2) + np.percentile(bearing, 98)) / 2
    depth = float(np.percentile(nearest[:, 2], 20))
    return np.array([middle * depth, 0.0, depth])


def _patches(places: Array, cell_size: float, closing: float = 1.0) -> list[NDArray[np.intp]]:
    """The rows of places (N, 2) that hang together on a grid of cells."""
    if not len(places):
        return []
    cell = np.floor(places / (closing * cell_size)).astype(np.int64)
    cell -= cell.min(axis=0)
    shape = cell.max(axis=0) + 1
    if np.prod(shape, dtype=np.float64) > 4e6:
        return []
    grid = np.zeros(shape, np.bool_)
    grid[tuple(cell.T)] = True
    number, count = label(grid, np.ones((3, 3)))
    of_row = number[tuple(cell.T)]
    return [np.flatnonzero(of_row == n) for n in range(1, count + 1)]
