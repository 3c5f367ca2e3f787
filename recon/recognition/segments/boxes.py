"""The upright box with the smallest footprint."""

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from recon.geometry import WORLD_UP
from recon.records import Box

Array = NDArray[np.float64]

MOST_POINTS = 1000
"""Maximum number of points that define a box: more do not change it."""
OUTLIERS = 0.01
"""Share of the points beyond either end of a box."""


def upright_box(points: Array) -> Box:
    """The box (y up) with the smallest footprint around the bulk of points (N, 3)."""
    points = np.ascontiguousarray(points[:: -(-len(points) // MOST_POINTS)])
    turns = _edge_directions(points[:, ::2])
    c, s, level = np.cos(turns), np.sin(turns), np.zeros(len(turns))
    frames = [np.column_stack([c, level, s]), np.column_stack([-s, level, c])]
    lows, highs = np.stack([_ends(points, directions, OUTLIERS) for directions in frames], axis=1)
    best = int(np.argmin(np.prod(highs - lows, axis=0)))
    axes = np.stack([frames[0][best], WORLD_UP, frames[1][best]])
    bottom, top = _ends(points, axes[1:2], OUTLIERS)[:, 0]
    low = np.array([lows[0, best], bottom, lows[1, best]])
    high = np.array([highs[0, best], top, highs[1, best]])
    return Box(centre=(low + high) / 2.0 @ axes, axes=axes, sizes=high - low)


@njit(cache=True)
def keep(value: float, lowest: Array) -> None:
    """Put a value among the lowest, ascending, if it is one of them."""
    k = len(lowest) - 1
    if value < lowest[k]:
        while k > 0 and lowest[k - 1] > value:
            lowest[k] = lowest[k - 1]
            k -= 1
        lowest[k] = value


@njit(cache=True)
def _ends(points: Array, directions: Array, share: float) -> Array:
    """Low and high quantiles (2, D) of points along directions (D, 3), a share from either end."""
    place = share * (len(points) - 1)
    rank = int(place)
    ends, kept = np.empty((2, len(directions))), np.empty((2, min(rank + 2, len(points))))
    for k in range(len(directions)):
        x, y, z = directions[k]
        kept[:] = np.inf
        for i in range(len(points)):
            along = x * points[i, 0] + y * points[i, 1] + z * points[i, 2]
            keep(along, kept[0])
            keep(-along, kept[1])
        for side in range(2):
            ends[side, k] = kept[side, rank] + (place - rank) * (kept[side, -1] - kept[side, rank])
        ends[1, k] *= -1.0
    return ends


def _edge_directions(floor: Array) -> Array:
    """Angles of the hull's edges: the smallest box is aligned with one of them."""
    try:
        corners = floor[ConvexHull(floor).vertices]
    except (QhullError, ValueError):
        return np.zeros(1)
    edges = np.roll(corners, -1, axis=0) - corners
    return np.unique(np.arctan2(edges[:, 1], edges[:, 0]) % (np.pi / 2.0))
