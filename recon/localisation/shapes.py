"""Guesses by shape: poses from which the object ahead may be one of the map.

Round objects look the same from all sides, and the map has several objects; features alone do not
show how many poses would look the same.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label

from recon.geometry import Array, pose, rotation_about_y
from recon.records import PointCloud, Voxels

NUM_BEARINGS = 36
MAX_SIGMA_CELLS = 3.0
"""Points with a larger sigma are ignored."""
MIN_POINTS, MIN_CELLS = 20, 8
"""Minimum points of an object ahead, and minimum cells of an object in the map."""
MAX_THINGS = 60
"""Maps with more objects are not searched by shape: it would take too long, and features are more
reliable there."""
LEVEL_COSINE = 0.966
"""Cameras tilted or rolled by more than 15 degrees get no guesses by shape."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Thing:
    """A patch of ground with an object on it."""

    centre: Array
    """(2,) x, z of the centre of its box."""
    radius: float
    """Half the width of its box."""


def things(voxels: Voxels) -> list[Thing]:
    """Separate objects of the map in top view."""
    found = []
    for rows in _patches(voxels.means[:, [0, 2]], voxels.cell_size):
        if len(rows) >= MIN_CELLS:
            low, high = (f(voxels.means[rows][:, [0, 2]], axis=0) for f in (np.min, np.max))
            found.append(Thing(centre=(low + high) / 2, radius=float((high - low).max()) / 2))
    return found


def guesses(cloud: PointCloud, voxels: Voxels, T_world_left: Array) -> list[Array]:
    """Poses (4, 4), at the height and tilt of one, that place the object ahead on mapped ones.

    Parameters
    ----------
    cloud : PointCloud
        Points of the pair, left frame.
    voxels : Voxels
    T_world_left : (4, 4) array
        A pose of the same robot for its height and tilt; no guesses if it is not nearly level.
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
    """The rotated pose whose offset (3,) leads to the near side of an object."""
    offset = turn @ offset
    x, z = thing.centre - offset[[0, 2]] * (1.0 + thing.radius / np.hypot(offset[0], offset[2]))
    return pose(turn @ T_world_left[:3, :3], [x, T_world_left[1, 3], z])


def _nearest_thing(cloud: PointCloud, cell_size: float) -> Array | None:
    """Centre (3,) of the front of the nearest object, left frame; None if there is none."""
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
    """The rows of connected positions (N, 2) on a grid of cells."""
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
