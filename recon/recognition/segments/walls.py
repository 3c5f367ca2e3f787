"""Walls: large upright planes with everything else in front of them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.recognition.fitting.shapes import from_points
from recon.records import FitFailure, Plane

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

NUM_DRAWS = 300
NUM_VOTERS = 3000
UPRIGHT = 0.26
"""Sine of the maximum tilt of a wall: 15 degrees."""
WALL_SHARE = 0.1
"""Minimum share of the standing cells on a wall."""
BEHIND_SHARE = 0.03
"""Maximum share of all cells behind a wall: seen through a door, or false."""
REACH = 0.5
"""Minimum width of a wall relative to the width of the scene along it."""
MOST_WALLS = 6


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Wall:
    """An upright plane and its cells."""

    plane: Plane
    """Its normal points towards the scene."""
    mask: Mask
    """Mask (N,) of the standing points on it."""


def find_walls(standing: Array, everything: Array, tolerance: float) -> list[Wall]:
    """The walls of a scene, the largest first.

    A wall has many cells, is nearly as wide as the scene, and has nearly nothing behind it, not
    even floor, unlike the side of a box.

    Parameters
    ----------
    standing : (N, 3) float64
        Points above the floor, level, y up.
    everything : (M, 3) float64
        The same points and those of the floor.
    tolerance : float
        Maximum distance of a point on a plane.
    """
    rng = np.random.default_rng(0)
    walls: list[Wall] = []
    rest = np.arange(len(standing))
    least = WALL_SHARE * len(standing)
    while len(rest) > max(least, 3) and len(walls) < MOST_WALLS:
        plane = _most_voted(standing[rest], everything, tolerance, rng)
        if plane is None:
            break
        on_plane = plane.distances(standing[rest]) < 2.0 * tolerance
        if on_plane.sum() < least or not _reaches_far(standing[rest][on_plane], plane, everything):
            break
        mask = np.zeros(len(standing), dtype=bool)
        mask[rest[on_plane]] = True
        walls.append(Wall(plane=plane, mask=mask))
        rest = rest[~on_plane]
    return walls


def _most_voted(
    points: Array, everything: Array, tolerance: float, rng: np.random.Generator
) -> Plane | None:
    """The upright plane with the most points on it and nothing behind it."""
    voters = points[rng.permutation(len(points))[:NUM_VOTERS]]
    witnesses = everything[rng.permutation(len(everything))[:NUM_VOTERS]]
    corners = voters[rng.integers(len(voters), size=(NUM_DRAWS, 3))]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    upright = np.abs(normals[:, 1]) < UPRIGHT * lengths
    normals, feet = normals[upright] / lengths[upright, None], corners[upright, 0]
    if not len(normals):
        return None
    offsets = np.einsum("ij,ij->i", normals, feet)
    before = witnesses @ normals.T - offsets
    sign = np.where(np.median(before, axis=0) < 0, -1.0, 1.0)
    is_last = (before * sign < -2.0 * tolerance).mean(axis=0) <= BEHIND_SHARE
    votes = (np.abs(voters @ normals.T - offsets) < tolerance).sum(axis=0) * is_last
    best = int(np.argmax(votes))
    if votes[best] < WALL_SHARE * len(voters):
        return None
    on_plane = np.abs(voters @ normals[best] - offsets[best]) < tolerance
    return _refined(voters[on_plane], sign[best] * normals[best])


def _refined(points: Array, normal: Array) -> Plane | None:
    fit = from_points("plane", points)
    if isinstance(fit, FitFailure) or not isinstance(fit.solid, Plane):
        return None
    sign = np.sign(fit.solid.normal @ normal)
    return Plane(point=fit.solid.point, normal=sign * fit.solid.normal)


def _reaches_far(points: Array, plane: Plane, everything: Array) -> bool:
    along = np.cross(plane.normal, [0.0, 1.0, 0.0])
    low, high = np.quantile(points @ along, [0.02, 0.98])
    all_low, all_high = np.quantile(everything @ along, [0.02, 0.98])
    return bool(high - low > REACH * (all_high - all_low))
