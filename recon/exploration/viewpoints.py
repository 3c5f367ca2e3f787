"""Viewpoints and the views from them."""

import math
from collections.abc import Sequence

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation

from recon.exploration.floor import NEIGHBOURS, Array, Mask
from recon.exploration.obstacles import Obstacle
from recon.exploration.paths import ShortestPaths
from recon.exploration.scales import Scales
from recon.exploration.scan import Detection
from recon.exploration.state import State, Walk

NUM_BEARINGS = 12
CLOSER = (1.0, 0.8, 0.6, 0.4, 1.2, 1.4)
"""Factors of the distances tried around an obstacle."""


def azimuth_of(direction_xz: Array) -> float:
    """Azimuth of a direction (2,) x, z."""
    return math.atan2(direction_xz[1], direction_xz[0])


def lifted(points_xz: Array, height: float) -> Array:
    """Points (..., 3) at a height above floor points (..., 2)."""
    x, z = np.moveaxis(points_xz, -1, 0)
    return np.stack([x, np.full_like(x, height), z], axis=-1)


def look_along(paths: ShortestPaths, place: Array, azimuth_rad: float, state: State) -> Walk:
    """The level view from a reachable position (2,) in a direction."""
    direction = np.array([math.cos(azimuth_rad), math.sin(azimuth_rad)])
    ahead = place + state.scales.gaze * direction
    return look_to(paths, place, lifted(ahead, state.scales.eye_height), state)


def look_at(
    paths: ShortestPaths, place: Array, obstacle: Obstacle | Detection, state: State
) -> Walk:
    """The view from a reachable position (2,) towards the centre of an obstacle."""
    return look_to(paths, place, middle_of(obstacle, state), state)


def look_to(paths: ShortestPaths, place: Array, target: Array, state: State) -> Walk:
    """The view from a reachable position (2,) towards a target (3,)."""
    height = state.scales.eye_height
    return Walk(
        position=lifted(place, height),
        target=target,
        via=lifted(paths.corners(place), height),
    )


def middle_of(obstacle: Obstacle | Detection, state: State) -> Array:
    """The target point (3,) of an obstacle, not below the cameras, so that the gaze is level."""
    height = state.scales.eye_height
    middle = max(height, obstacle.top / 2.0) if isinstance(obstacle, Obstacle) else height
    return lifted(obstacle.centre, middle)


def vantage_points(paths: ShortestPaths, unknown: Mask, scales: Scales) -> Array:
    """Reachable positions (N, 2) that are worth looking around from.

    These are the frontier, the cells that border on unknown ones except ground along obstacles,
    where the agent does not walk; and positions all over the known ground, since much of the
    unknown ground is visible from afar.
    """
    reached = np.isfinite(paths.distance)
    border = binary_dilation(unknown, NEIGHBOURS, iterations=scales.border)
    near, anywhere = scales.blocks
    frontier = _one_per_block(np.argwhere(reached & border), paths.distance, near)
    open_ground = _one_per_block(np.argwhere(reached), paths.distance, anywhere)
    return paths.floor.centres(np.vstack([frontier, open_ground]))


def _one_per_block(cells: NDArray[np.intp], distance: Array, block: int) -> NDArray[np.intp]:
    """The nearest of the cells (N, 2) in each square of block x block cells."""
    width = 1 + distance.shape[1] // block
    number = cells // block @ np.array([width, 1])
    first = _nearest(number, distance[tuple(cells.T)], width * (1 + distance.shape[0] // block))
    nearest: NDArray[np.intp] = cells[first[first >= 0]]
    return nearest


@njit(cache=True)
def _nearest(number: NDArray[np.intp], distance: Array, num_groups: int) -> NDArray[np.intp]:
    """Row of the first nearest entry of each group that the entries belong to; -1 = none."""
    nearest = np.full(num_groups, -1, np.intp)
    for row in range(len(number)):
        best = nearest[number[row]]
        if best < 0 or distance[row] < distance[best]:
            nearest[number[row]] = row
    return nearest


def viewpoint(
    paths: ShortestPaths, obstacle: Obstacle | Detection, bearing_rad: float, clearance: float
) -> Array | None:
    """The viewpoint (2,) of an obstacle on one bearing; None if none is reachable.

    If something is in the way, the distance is first reduced, then increased.
    """
    places = _viewpoints(paths, [obstacle], np.array([bearing_rad]), clearance)
    return places[0] if len(places) else None


def viewpoints_round(
    paths: ShortestPaths, wanted: Sequence[Obstacle | Detection], clearance: float
) -> Array:
    """Reachable positions (N, 2) around obstacles, on some bearings of each."""
    bearings_rad = np.linspace(0.0, 2.0 * math.pi, NUM_BEARINGS, endpoint=False)
    return _viewpoints(paths, wanted, bearings_rad, clearance)


def _viewpoints(
    paths: ShortestPaths,
    wanted: Sequence[Obstacle | Detection],
    bearings_rad: Array,
    clearance: float,
) -> Array:
    """Positions (N, 2) to look at obstacles from, one per bearing (B,) with a reachable one."""
    directions = np.column_stack([np.cos(bearings_rad), np.sin(bearings_rad)])
    centres = np.array([one.centre for one in wanted]).reshape(-1, 1, 1, 2)
    radii = np.array([one.radius for one in wanted]).reshape(-1, 1, 1, 1)
    away = radii + clearance * np.array(CLOSER)[:, None]
    places = centres + away * directions[:, None]
    reached = paths.reaches(places)
    some = reached.any(axis=-1)
    nearest: Array = places[some, reached[some].argmax(axis=-1)]
    return nearest
