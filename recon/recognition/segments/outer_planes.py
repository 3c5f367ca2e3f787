"""The slopes of a gabled roof: slanted planes on the outside of an object, compiled.

Seen from below, a roof has cells only at its eaves, its ridge and on top of its gables: nothing on
it hangs together. What gives it away is that it touches all these, and that nothing is beyond it.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from recon.recognition.segments.boxes import keep
from recon.recognition.segments.peeling import ON_PLANE_CELLS, near_plane, width
from recon.recognition.segments.plane_votes import fitted_plane, sum_of_votes, votes_for

Array = NDArray[np.float64]
Rows = NDArray[np.int64]

BEYOND = 0.02
"""Share of the points beyond an outer plane: these are outliers."""
OPPOSITE = 0.9
"""Minimum cosine of the angle between a slope's azimuth and the opposite of the other's."""
NUM_AZIMUTHS = 48
TILTS_DEG = (20.0, 27.5, 35.0, 42.5, 50.0, 57.5, 65.0)
"""Directions to choose from; the plane found is fitted to its points."""
OVER_EDGE = 2.0
"""Minimum width of an outer plane, over that of what a plane touches at the edge of a box."""
MOST_POINTS = 300
"""Approximate maximum number of points among which a direction is chosen."""
NUM_ROUNDS = 5


@njit(cache=True)
def outer_planes(points: Array, cell_size: float, least: int) -> tuple[Array, Array, Rows]:
    """The two slopes of a gabled roof, in opposite directions.

    One slope alone is also what a bench touches, or a box on a larger one.

    Parameters
    ----------
    points : (N, 3)
    cell_size : float
        Distance up to which points vote.
    least : int
        Minimum number of points of a plane.

    Returns
    -------
    places, normals : (2, 3)
    number : (N,) plane of each point; -1 = on none, as all are if there is no such roof
    """
    places, normals = np.zeros((2, 3)), np.zeros((2, 3))
    none = np.full(len(points), -1)
    number = none.copy()
    if len(points) < least:
        return places, normals, none
    for slope in range(2):
        # Both touch the ridge, whose points are those of the first.
        place, normal = _outermost_plane(points, -normals[0], cell_size)
        own = near_plane(points, place, normal, ON_PLANE_CELLS * cell_size)
        if not _is_slope(points, own, normal, cell_size, least):
            return places, normals, none
        places[slope], normals[slope] = place, normal
        number[own] = np.where(number[own] < 0, slope, number[own])
    return places, normals, number


@njit(cache=True)
def _outermost_plane(points: Array, facing: Array, reach: float) -> tuple[Array, Array]:
    """The slanted plane that touches most points from outside, and above."""
    place, normal = _chosen(points[:: -(-len(points) // MOST_POINTS)], facing, reach)
    for _ in range(NUM_ROUNDS):
        place, normal = fitted_plane(points, votes_for(points, place, normal, reach), False)
    return place, -normal if normal[1] < 0.0 else normal


@njit(cache=True)
def _is_slope(points: Array, own: Rows, normal: Array, cell_size: float, least: int) -> bool:
    """True if points on a plane are enough, and too wide for the edge of a box."""
    edge = 2.0 * ON_PLANE_CELLS * cell_size * OVER_EDGE
    slant = abs(normal[1]) * math.sqrt(max(1.0 - normal[1] ** 2, 0.0))
    return len(own) >= least and width(points[own]) * slant >= edge


@njit(cache=True)
def _chosen(points: Array, facing: Array, reach: float) -> tuple[Array, Array]:
    """The direction, facing another one unless that is 0, whose plane has the most votes."""
    best, place, normal = -1.0, np.zeros(3), np.array([0.0, 1.0, 0.0])
    columns = np.ascontiguousarray(points.T)
    for tilt_deg in TILTS_DEG:
        tilt = math.radians(tilt_deg)
        for number in range(NUM_AZIMUTHS):
            azimuth = 2.0 * math.pi * number / NUM_AZIMUTHS
            x, z = math.cos(azimuth), math.sin(azimuth)
            if x * facing[0] + z * facing[2] < OPPOSITE * math.hypot(facing[0], facing[2]):
                continue
            x, z = math.sin(tilt) * x, math.sin(tilt) * z
            direction = np.array([x, math.cos(tilt), z])
            top = direction * _outermost(points, direction)
            total = sum_of_votes(columns, top, direction, reach)
            if total > best:
                best, place, normal = total, top, direction
    return place, normal


@njit(cache=True)
def _outermost(points: Array, direction: Array) -> float:
    """Position along a direction beyond which there are only outliers."""
    farthest = np.full(int(BEYOND * len(points)) + 1, np.inf)
    for i in range(len(points)):
        along = (
            points[i, 0] * direction[0] + points[i, 1] * direction[1] + points[i, 2] * direction[2]
        )
        keep(-along, farthest)
    outermost: float = -farthest[-1]
    return outermost
