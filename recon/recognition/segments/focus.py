"""The position that all views look at, as on a ring around one object."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LEAST_VIEWS = 3
NEAR = 0.3
"""Maximum distance between the axes and the position, relative to the cameras' distance: within the
field of view of a narrow lens, whose rectified axis need not pass through the image centre."""
SPREAD = 0.1
"""Minimum of the middle eigenvalue of the axes' scatter, which is 1/3 for axes from all directions:
three views within about 30 degrees always look at some position."""
WITHIN = 0.5
"""Cells closer to the position than this share of the cameras' distance belong to it."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Focus:
    """A position and its radius."""

    centre: Array
    """(3,) world."""
    radius: float

    def holds(self, points: Array) -> NDArray[np.bool_]:
        """Mask (N,) of the points (N, 3) within the radius."""
        near: NDArray[np.bool_] = np.linalg.norm(points - self.centre, axis=1) < self.radius
        return near


def find_focus(T_world_left: Array) -> Focus | None:
    """The position nearest to the axes of all cameras (N, 4, 4); None if there is none.

    The position must be in front of every camera, and the axes must pass close to it.
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
