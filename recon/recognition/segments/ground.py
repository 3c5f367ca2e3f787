"""The ground: as given, or the largest level plane."""

import numpy as np
from numpy.typing import NDArray

from recon.geometry import WORLD_UP, pose
from recon.recognition.fitting.shapes import from_points
from recon.records import FitFailure, Plane

Array = NDArray[np.float64]

NUM_DRAWS = 400
NUM_VOTERS = 4000
STEEPEST = 0.5
"""Cosine of the maximum tilt of a floor: a hand-held camera looks down by up to 60 degrees."""
TOLERANCE = 0.005
"""Maximum distance of a point on the floor, as a share of the cloud's size."""
BULK = (0.05, 0.95)
"""Quantiles that bound the bulk of a cloud."""
FLOOR_SHARE = 0.15
"""Minimum share of the points on a floor."""
BELOW_SHARE = 0.4
"""Maximum share of the points below a floor, seen past its edge."""


def level_plane(points: Array) -> Array | None:
    """Transform (4, 4) that maps the largest level plane of points (N, 3), y up, to y = 0.

    None if no plane holds enough of the points with nearly all others above it.
    """
    if len(points) < 3:
        return None
    rng = np.random.default_rng(0)
    voters = points[rng.permutation(len(points))[:NUM_VOTERS]]
    tolerance = TOLERANCE * extent(points)
    on_floor, normal = _most_voted(voters, tolerance, rng)
    if normal is None or on_floor.mean() < FLOOR_SHARE:
        return None
    refined = from_points("plane", voters[on_floor])
    if isinstance(refined, FitFailure) or not isinstance(refined.solid, Plane):
        return None
    plane = refined.solid
    return _floor_motion(plane.point, plane.normal * np.sign(plane.normal @ normal))


def extent(points: Array) -> float:
    """Longest side of the box of points (N, 3), without outliers."""
    low, high = np.quantile(points, BULK, axis=0)
    return float((high - low).max())


def _most_voted(
    voters: Array, tolerance: float, rng: np.random.Generator
) -> tuple[NDArray[np.bool_], Array | None]:
    """Mask of the voters on the level plane with the most of them, and its upward normal.

    Of those planes that have nearly all others above them: a table top may have more voters than
    the floor.
    """
    corners = voters[rng.integers(len(voters), size=(NUM_DRAWS, 3))]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    level = np.abs(normals[:, 1]) > STEEPEST * np.maximum(lengths, 1e-300)
    if not level.any():
        return np.zeros(len(voters), dtype=bool), None
    signs = np.sign(normals[level, 1]) / lengths[level]
    normals, feet = normals[level] * signs[:, None], corners[level, 0]
    offsets = np.einsum("ij,ij->i", normals, feet)
    heights = voters @ normals.T - offsets
    on_plane = np.abs(heights) < tolerance
    is_low = (heights < -2.0 * tolerance).mean(axis=0) <= BELOW_SHARE
    best = int(np.argmax(on_plane.sum(axis=0) * is_low))
    return on_plane[:, best] & is_low[best], normals[best]


def _floor_motion(point: Array, up: Array) -> Array:
    """The smallest rotation that maps `up` to y, with `point` mapped to y = 0."""
    axis = np.cross(up, WORLD_UP)
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    rotation = np.eye(3) + cross + cross @ cross / (1.0 + up[1])
    return pose(rotation, [0.0, -(rotation @ point)[1], 0.0])
