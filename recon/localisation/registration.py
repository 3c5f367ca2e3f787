"""Registration of a pair's points to the surface of a map by generalised ICP.

Each point has the uncertainty of stereo along its ray and a far smaller one across it: a point on
the outline of a trunk determines the direction well although its depth is poor (Segal, Haehnel and
Thrun 2009, with point-to-plane distances). Points on one cell share the cell's error, so they count
as one.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from recon.geometry import pose, without_drift
from recon.localisation.surfels import Surfels

Array = NDArray[np.float64]

NUM_ROUNDS = 25
FIRST_REACH, LAST_REACH, SHRINKING = 3.0, 1.5, 0.8
"""Search radius of a point in cells: initial, final, and the factor per round."""
SURFACE_SIGMA = 0.12
"""Standard deviation of the distance of a surface from the mean of its cell, in cells."""
ACROSS_PX = 0.7
"""Standard deviation of a point across its ray, pixels."""
MIN_CELLS = 8
"""Fewer cells do not determine a pose."""
SMALL_CHANGE = 1e-4
MAX_SIGMAS = 3.0
SLIDES = np.array([0.0, -0.5, 0.5, -1.0, 1.0, -1.5, 1.5, -2.0, 2.0, -2.5, 2.5])
"""Shifts along their rays at which uncertain points are tried, standard deviations."""
UNCERTAIN_CELLS, NEAR_CELLS = 0.7, 0.5
"""Standard deviation from which on a point is uncertain, and distance from a surface that is worth
a shift by one standard deviation, in cells."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Points:
    """Points of a pair with their uncertainties."""

    points_left: Array
    """(N, 3)"""
    sigma: Array
    """(N,) standard deviation along the ray, world units."""
    across: Array
    """(N,) standard deviation across the ray, world units."""

    def __len__(self) -> int:
        return len(self.points_left)

    def select(self, rows: NDArray[np.integer] | NDArray[np.bool_]) -> "Points":
        """Some of the points."""
        return Points(
            points_left=self.points_left[rows], sigma=self.sigma[rows], across=self.across[rows]
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Prior:
    """Prior of a pose."""

    T_world_left: Array
    information: Array
    """(6, 6) inverse covariance, in the order of `PoseEstimate`."""

    def pull(self, T_world_left: Array) -> Array:
        """Small rotation and shift (6,) from the prior pose to this one."""
        turn = T_world_left[:3, :3] @ self.T_world_left[:3, :3].T
        shift = T_world_left[:3, 3] - self.T_world_left[:3, 3]
        return np.concatenate([Rotation.from_matrix(turn).as_rotvec(), shift])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Contacts:
    """Cells that points are on at a pose."""

    residual: Array
    """(C,) distance of the points from the surface, standard deviations."""
    by_pose: Array
    """(C, 6) derivative of the residual by a small rotation and shift."""
    num_near: int
    """Number of points near a piece of surface."""
    num_points: int
    """Number of points on it, within 3 standard deviations."""

    @property
    def spread(self) -> float:
        """Robust standard deviation of the residuals, independent of what has moved."""
        return float(np.median(np.abs(self.residual))) / 0.6745

    @property
    def weights(self) -> Array:
        """Cauchy weights (C,)."""
        return 1.0 / (1.0 + self.residual**2)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Registration:
    """A pose and the fit of the points to the surface."""

    T_world_left: Array
    information: Array
    """(6, 6) information from the points alone."""
    contacts: Contacts


def register(
    points: Points, surfels: Surfels, prior: Prior, *, slides: bool = False
) -> Registration | None:
    """The pose at which the points are on the surface; None if too few are.

    If they slide, points of uncertain depth are put on the surface along their rays, so that far
    objects determine the direction although their distance is hardly known.
    """
    T, reach = prior.T_world_left, FIRST_REACH
    for _ in range(NUM_ROUNDS):
        there = slid(points, surfels, T) if slides else points
        contacts = touch(there, surfels, T, reach * surfels.cell_size)
        if len(contacts.residual) < MIN_CELLS:
            return None
        information, gradient = _normal_equations(contacts, prior, T)
        change = -inverse(information) @ gradient
        T = moved(T, change)
        reach = max(LAST_REACH, SHRINKING * reach)
        if np.abs(change).max() < SMALL_CHANGE:
            break
    there = slid(points, surfels, T) if slides else points
    contacts = touch(there, surfels, T, LAST_REACH * surfels.cell_size)
    if len(contacts.residual) < MIN_CELLS:
        return None
    return Registration(T_world_left=T, information=_information(contacts), contacts=contacts)


def slid(points: Points, surfels: Surfels, T_world_left: Array) -> Points:
    """Uncertain points at the likeliest place along their rays, as near to a surface."""
    uncertain = points.sigma > UNCERTAIN_CELLS * surfels.cell_size
    from_left = points.points_left[uncertain]
    distance = np.linalg.norm(from_left, axis=1)
    shift = SLIDES * points.sigma[uncertain, None]
    # A point stays in front of the camera.
    factor = np.maximum(1.0 + shift / distance[:, None], 0.05)
    tried = from_left[:, None] * factor[..., None]
    most = 2.0 * FIRST_REACH * surfels.cell_size
    world = tried.reshape(-1, 3) @ T_world_left[:3, :3].T + T_world_left[:3, 3]
    away = np.minimum(surfels.tree.query(world, distance_upper_bound=most)[0], most)
    cost = (away.reshape(shift.shape) / (NEAR_CELLS * surfels.cell_size)) ** 2 + SLIDES**2
    moved_points = points.points_left.copy()
    moved_points[uncertain] = tried[np.arange(len(tried)), cost.argmin(axis=1)]
    return replace(points, points_left=moved_points)


def inverse(matrix: Array) -> Array:
    """The inverse of a covariance or information matrix."""
    return np.asarray(np.linalg.inv(matrix), dtype=np.float64)


def moved(T_world_left: Array, change: Array) -> Array:
    """The pose after a small rotation `change[:3]` about the camera and a shift `change[3:]`."""
    turn = Rotation.from_rotvec(change[:3]).as_matrix()
    return without_drift(pose(turn @ T_world_left[:3, :3], T_world_left[:3, 3] + change[3:]))


def _information(contacts: Contacts) -> Array:
    weighted = contacts.by_pose * contacts.weights[:, None]
    information: Array = weighted.T @ contacts.by_pose
    return information


def _normal_equations(contacts: Contacts, prior: Prior, T_world_left: Array) -> tuple[Array, Array]:
    gradient = contacts.by_pose.T @ (contacts.weights * contacts.residual)
    gradient += prior.information @ prior.pull(T_world_left)
    return _information(contacts) + prior.information, gradient


def touch(points: Points, surfels: Surfels, T_world_left: Array, reach: float) -> Contacts:
    """The cells that the points are on, and their distances."""
    R, eye = T_world_left[:3, :3], T_world_left[:3, 3]
    offset = points.points_left @ R.T
    rows, cell = surfels.under(offset + eye, reach)
    offset = offset[rows]
    normal = surfels.normals[cell]
    gap = np.einsum("ni,ni->n", normal, offset + eye - surfels.means[cell])
    along = np.einsum("ni,ni->n", normal, offset) / np.linalg.norm(offset, axis=1)
    # Variance of the distance: the parts of the normal along and across the ray.
    variance = points.sigma[rows] ** 2 * along**2 + points.across[rows] ** 2 * (1.0 - along**2)
    surface = SURFACE_SIGMA * surfels.cell_size
    is_near = np.abs(gap) < MAX_SIGMAS * np.sqrt(variance + surface**2)
    residual, by_pose = _by_cell(cell, surfels, np.column_stack([gap, offset]), variance)
    return Contacts(
        residual=residual, by_pose=by_pose, num_near=len(rows), num_points=int(is_near.sum())
    )


def _by_cell(
    cell: NDArray[np.intp], surfels: Surfels, gap_and_offset: Array, variance: Array
) -> tuple[Array, Array]:
    """Residuals (C,) and derivatives (C, 6) of the cells, whose points share the cell's error."""
    cells, row = np.unique(cell, return_inverse=True)
    weight = 1.0 / np.maximum(variance, 1e-12)
    total = np.bincount(row, weight, len(cells))
    means = [np.bincount(row, weight * c, len(cells)) / total for c in gap_and_offset.T]
    arm, normal = np.column_stack(means[1:]).reshape(-1, 3), surfels.normals[cells]
    sigma = np.hypot(total**-0.5, SURFACE_SIGMA * surfels.cell_size)
    by_pose = np.column_stack([np.cross(arm, normal), normal]) / sigma[:, None]
    return means[0] / sigma, by_pose
