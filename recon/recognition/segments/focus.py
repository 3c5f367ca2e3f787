"""The place that all views look at, as they do on a ring round one object."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LEAST_VIEWS = 3
NEAR = 0.3
"""Distance at which the axes pass the place, as a share of that of the cameras: within the field
of a narrow lens, whose rectified axis need not go through the middle of the image."""
SPREAD = 0.1
"""Least of the middle eigenvalue of the axes' scatter, 1/3 where they come from everywhere: by
three views within some 30 degrees any place is looked at."""
WITHIN = 0.5
"""Cells nearer to the place than this share of the cameras' distance belong to it."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Focus:
    """A place and its reach."""

    centre: Array
    """(3,) world."""
    radius: float

    def holds(self, points: Array) -> NDArray[np.bool_]:
        """(N,) which points (N, 3) are there."""
        near: NDArray[np.bool_] = np.linalg.norm(points - self.centre, axis=1) < self.radius
        return near


def find_focus(T_world_left: Array) -> Focus | None:
    """The place nearest to the axes of all cameras (N, 4, 4); None where they have none.

    The same place in space must lie before every camera, and the axes must pass close by it.
    """
    if len(T_world_left) < LEAST_VIEWS:
        return None
    eyes, axes = T_world_left[:, :3, 3], T_world_left[:, :3, 2]
    scatter = np.linalg.eigvalsh(axes.T @ axes / len(axes))
    if scatter[1] < SPREAD:
        return None
    across = np.eye(3) - axes[:, :, None] * axes[:, None, :]
    centre = np.linalg.solve(across.sum(axis=0), np.einsum("nij,nj->i", across, eyes))
    rays = centre - eyes
    distances = np.linalg.norm(rays, axis=1)
    passes = np.linalg.norm(np.einsum("nij,nj->ni", across, rays), axis=1)
    ahead = np.einsum("ij,ij->i", rays, axes) > 0
    if not ahead.all() or np.median(passes / distances) > NEAR:
        return None
    return Focus(centre=centre, radius=WITHIN * float(np.median(distances)))
