"""Outlines: the things before the cameras by the directions of their edges.

The middle between the edges of a thing is where the thing is, near or far; the middle of its points
is where its texture is.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.exploration.floor import Array
from recon.exploration.scales import Scales
from recon.exploration.scan import MIN_POINTS, MIN_POINTS_DISTANCE, groups, polar, sigma_of
from recon.geometry import wrapped
from recon.records import PointCloud

OUTERMOST = 3
"""A point of this rank from outside is the edge: those beyond may be noise."""
GAP_RAD = math.radians(1.0)
"""What comes so near to an edge, the border of the image or a nearer thing, may hide the rest."""
PART_CELLS = 1.5
"""Parts of one thing are at most so far apart, sideways; two more than that behind one another."""
NUM_SIGMAS = 3.0
"""Of the difference of two distances that are one."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Outline:
    """A thing as one pair sees it."""

    edges_rad: Array
    """(2,) azimuths of its edges, from straight ahead, growing clockwise seen from above."""
    is_free: NDArray[np.bool_]
    """(2,) whether each is an edge of the thing, and not of what hides the rest."""
    distance: float
    """Distance of its points, world units."""
    sigma: float
    """Standard deviation of that."""

    @property
    def middle_rad(self) -> float:
        """Azimuth midway between the edges."""
        return float(self.edges_rad.mean())

    @property
    def half_rad(self) -> float:
        """Half the angle between the edges."""
        return float(np.diff(self.edges_rad)[0]) / 2.0

    def overlaps(self, other: "Outline", gap: float = 0.0) -> bool:
        """True where both are seen in one direction, or nearer to it than a gap."""
        reach = self.half_rad + other.half_rad + gap
        return abs(self.middle_rad - other.middle_rad) < reach


def outlines(standing: PointCloud, pose: Array, half_field: float, scales: Scales) -> list[Outline]:
    """The outlines of what stands before a camera, the nearest first.

    Parameters
    ----------
    standing : PointCloud
        Points above the ground, world.
    pose : (3,) array
        x, z of the camera, and the azimuth of straight ahead.
    half_field : float
        Half the width of the field of view, radians.
    scales : Scales
    """
    azimuth, distance = polar(standing.points[:, [0, 2]], pose[:2])
    side, sigma = wrapped(azimuth - pose[2]), sigma_of(standing)
    number = groups(side, distance / scales.cell)
    reach = MIN_POINTS_DISTANCE * scales.viewing_distance
    found = []
    for rows in (number == n for n in range(number.max(initial=-1) + 1)):
        if rows.sum() >= max(MIN_POINTS, (reach / np.median(distance[rows])) ** 2):
            found.append(_outline(side[rows], distance[rows], sigma[rows]))
    return _freed(_joined(found, scales.cell), half_field)


def _outline(side: Array, distance: Array, sigma: Array) -> Outline:
    ordered = np.sort(side)
    return Outline(
        edges_rad=ordered[[OUTERMOST - 1, -OUTERMOST]],
        is_free=np.ones(2, np.bool_),
        distance=float(np.median(distance)),
        # Errors of one thing's points are not independent: their mean gains less than sqrt(N).
        sigma=float(np.median(sigma)) / 2.0,
    )


def _joined(found: list[Outline], cell: float) -> list[Outline]:
    """The outlines, parts that are one behind the other within their error taken together."""
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
    """The nearer part tells the distance, both the edges."""
    edges = np.array([near.edges_rad, far.edges_rad])
    return Outline(
        edges_rad=np.array([edges[:, 0].min(), edges[:, 1].max()]),
        is_free=near.is_free,
        distance=near.distance,
        sigma=near.sigma,
    )


def _freed(found: list[Outline], half_field: float) -> list[Outline]:
    """The outlines with what hides their edges: the border of the image, and nearer things."""
    freed = []
    for row, one in enumerate(found):
        is_free = np.abs(one.edges_rad) < half_field - GAP_RAD
        for nearer in found[:row]:
            off = np.abs(one.edges_rad - nearer.middle_rad)
            is_free &= off > nearer.half_rad + GAP_RAD
        freed.append(
            Outline(
                edges_rad=one.edges_rad, is_free=is_free, distance=one.distance, sigma=one.sigma
            )
        )
    return freed
