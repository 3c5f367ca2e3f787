"""The upright box with the smallest footprint."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from recon.records import Box

Array = NDArray[np.float64]

MOST_POINTS = 1000
"""Maximum number of points that define a box: more do not change it."""
BULK = (0.01, 0.99)
"""Quantiles of the points at the ends of a box: the few beyond them are outliers."""


def upright_box(points: Array) -> Box:
    """The box (y up) with the smallest footprint around the bulk of points (N, 3)."""
    points = points[:: -(-len(points) // MOST_POINTS)]
    floor = points[:, ::2]
    turns = _edge_directions(floor)
    along = floor @ np.stack([np.cos(turns), np.sin(turns)])
    across = floor @ np.stack([-np.sin(turns), np.cos(turns)])
    lows, highs = np.quantile(np.stack([along, across]), BULK, axis=1)
    best = int(np.argmin(np.prod(highs - lows, axis=0)))
    c, s = np.cos(turns[best]), np.sin(turns[best])
    axes = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    bottom, top = np.quantile(points[:, 1], BULK)
    low = np.array([lows[0, best], bottom, lows[1, best]])
    high = np.array([highs[0, best], top, highs[1, best]])
    return Box(centre=(low + high) / 2.0 @ axes, axes=axes, sizes=high - low)


def _edge_directions(floor: Array) -> Array:
    """Angles of the hull's edges: the smallest box is aligned with one of them."""
    try:
        corners = floor[ConvexHull(floor).vertices]
    except (QhullError, ValueError):
        return np.zeros(1)
    edges = np.roll(corners, -1, axis=0) - corners
    return np.unique(np.arctan2(edges[:, 1], edges[:, 0]) % (np.pi / 2.0))
