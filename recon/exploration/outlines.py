"""Outlines: the objects in view, by the directions of their edges.

The middle between an object's edges is the direction of the object, near or far; the middle of its
points is only that of its texture.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from recon.exploration.floor import Array
from recon.exploration.scales import Scales
from recon.exploration.scan import (
    MIN_POINTS,
    MIN_POINTS_DISTANCE,
    groups,
    polar,
    range_steps,
    sigma_of,
)
from recon.geometry import wrapped
from recon.records import PointCloud

OUTERMOST = 3
"""Rank, from outside, of the point taken as the edge: points beyond it may be noise."""
GAP_RAD = math.radians(1.0)
"""An image border or a nearer object within this angle of an edge may hide the rest."""
PART_CELLS = 1.5
"""Maximum sideways gap between parts of one object, in cells; in depth, two cells are allowed."""
NUM_SIGMAS = 3.0
"""Maximum difference, in standard deviations, of two distances that are the same."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Outline:
    """An object as seen by one pair."""

    edges_rad: Array
    """(2,) azimuths of its edges from straight ahead, clockwise as seen from above."""
    is_free: NDArray[np.bool_]
    """(2,) whether each edge is its own, and not that of something that hides the rest."""
    distance: float
    """Distance of its points, world units."""
    sigma: float
    """Standard deviation of the distance."""

    @property
    def middle_rad(self) -> float:
        """Azimuth midway between the edges."""
        return float(self.edges_rad.mean())

    @property
    def half_rad(self) -> float:
        """Half the angle between the edges."""
        return float(np.diff(self.edges_rad)[0]) / 2.0

    def overlaps(self, other: "Outline", gap: float = 0.0) -> bool:
        """True if both are in the same direction, or apart by less than a gap (radians)."""
        reach = self.half_rad + other.half_rad + gap
        return abs(self.middle_rad - other.middle_rad) < reach


def outlines(
    standing: PointCloud, rims: Array, pose: Array, half_field: float, scales: Scales
) -> list[Outline]:
    """The outlines of the objects in front of a camera, nearest first.

    Parameters
    ----------
    standing : PointCloud
        Points above the ground, world.
    rims : (N, 2) array
        Azimuths of the edges to the left and right of each point.
    pose : (3,) array
        x, z of the camera, and the azimuth of straight ahead.
    half_field : float
        Half the width of the field of view, radians.
    scales : Scales
    """
    azimuth, distance = polar(standing.points[:, [0, 2]], pose[:2])
    side, sigma = wrapped(azimuth - pose[2]), sigma_of(standing)
    edges = np.sort(wrapped(rims - pose[2]), axis=1)
    number = groups(side, range_steps(distance / scales.cell))
    reach = MIN_POINTS_DISTANCE * scales.viewing_distance
    found = []
    for rows in (number == n for n in range(number.max(initial=-1) + 1)):
        if rows.sum() >= max(MIN_POINTS, (reach / np.median(distance[rows])) ** 2):
            found.append(_outline(edges[rows], distance[rows], sigma[rows]))
    return _freed(_joined(found, scales.cell), half_field)


def _outline(edges: Array, distance: Array, sigma: Array) -> Outline:
    least, most = np.sort(edges, axis=0).T
    return Outline(
        edges_rad=np.array([least[OUTERMOST - 1], most[-OUTERMOST]]),
        is_free=np.ones(2, np.bool_),
        distance=float(np.median(distance)),
        # Errors of an object's points are not independent: averaging gains less than sqrt(N).
        sigma=float(np.median(sigma)) / 2.0,
    )


def _joined(found: list[Outline], cell: float) -> list[Outline]:
    """The outlines, with parts merged that lie behind each other within their errors."""
    joined: list[Outline] = []
    for one in sorted(found, key=lambda one: one.distance):
        for row, other in enumerate(joined):
            apart = one.distance - other.distance - 2.0 * cell
            if one.overlaps(
                other, PART_CELLS * cell / one.distance
            ) and apart < NUM_SIGMAS * 2.0 * math.hypot(one.sigma, other.sigma):
                joined[row] = _both(other, one)
                break
        else:
            joined.append(one)
    return joined


def _both(near: Outline, far: Outline) -> Outline:
    """Both parts as one: the distance of the nearer one, the outer edges of both."""
    edges = np.array([near.edges_rad, far.edges_rad])
    return replace(near, edges_rad=np.array([edges[:, 0].min(), edges[:, 1].max()]))


def _freed(found: list[Outline], half_field: float) -> list[Outline]:
    """The outlines, with edges marked that the image border or nearer objects may hide."""
    freed = []
    for row, one in enumerate(found):
        is_free = np.abs(one.edges_rad) < half_field - GAP_RAD
        for nearer in found[:row]:
            off = np.abs(one.edges_rad - nearer.middle_rad)
            is_free &= off > nearer.half_rad + GAP_RAD
        freed.append(replace(one, is_free=is_free))
    return freed
