"""Rims: the silhouette edges of objects beside their points.

Matched points stop a pixel or two before the outline of an object, by its texture; the outline
itself is the farthest edge of the image within a few pixels, and is found to a part of a pixel.
"""

import numpy as np
from numpy.typing import NDArray

from recon.exploration.floor import Array
from recon.geometry import invert, transform
from recon.records import PointCloud, StereoPair

REACH_PX = 4
"""Distance along the row within which the outline is looked for."""
MIN_STEP = 12.0
"""Minimum difference of grey levels over two pixels at an edge."""


def rims(cloud: PointCloud, pair: StereoPair) -> Array:
    """Azimuths (N, 2) of the farthest edges to the left and right of points; their own if none.

    Parameters
    ----------
    cloud : PointCloud
        Points of the pair, in the world.
    pair : StereoPair
        With its pose.
    """
    assert pair.T_world_left is not None
    rig, T_world_left = pair.rig, pair.T_world_left
    image = pair.left.astype(np.float64).reshape(*pair.left.shape[:2], -1).mean(axis=2)
    offset, is_edge = _edges(image)
    points_px = rig.project_left(transform(invert(T_world_left), cloud.points))
    column, row = np.rint(points_px).astype(np.intp).T
    row = row.clip(0, len(image) - 1)
    azimuths = []
    for side in (-1, 1):
        rim = points_px[:, 0].copy()
        for shift in range(REACH_PX + 1):
            there = (column + side * shift).clip(0, image.shape[1] - 1)
            rim = np.where(is_edge[row, there], there + offset[row, there], rim)
        rays = rig.rays(np.column_stack([rim, points_px[:, 1]])) @ T_world_left[:3, :3].T
        azimuths.append(np.arctan2(rays[:, 2], rays[:, 0]))
    return np.column_stack(azimuths)


def _edges(image: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Offsets (H, W) of the edges along the rows from their pixels, and where edges are."""
    step = np.zeros_like(image)
    step[:, 1:-1] = np.abs(image[:, 2:] - image[:, :-2])
    before, after = np.roll(step, 1, axis=1), np.roll(step, -1, axis=1)
    is_edge = (step >= before) & (step > after) & (step > MIN_STEP)
    bend = np.where(is_edge, before - 2.0 * step + after, -1.0)
    return np.where(is_edge, 0.5 * (before - after) / bend, 0.0), is_edge
