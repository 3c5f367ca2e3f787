"""Gains of views: ground that nobody has seen, and new sides of obstacles."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from recon.exploration.floor import ROUNDING, Array, Floor, Mask
from recon.exploration.obstacles import Obstacle
from recon.exploration.scan import Detection, polar

NUM_RAYS = 90
SPACING_RAD = 2.0 * math.pi / NUM_RAYS
AZIMUTHS_RAD: Array = np.linspace(0.0, 2.0 * math.pi, NUM_RAYS, endpoint=False)
SAMPLE = 2.0
"""Cells between two samples along a ray; less than half an obstacle's width."""
NEW_SIDE_RAD = np.radians(90.0)
"""A bearing this far from all earlier ones shows a wholly new side of an obstacle."""
SAME_GAZE_RAD = math.radians(20.0)
"""A view from the same place, turned by no more, shows nothing that the earlier one did not."""
MIN_NOVELTY = 0.25
"""Less of a new side than this is the old one."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Candidates:
    """Views that could be taken next."""

    places: Array
    """(C, 2) x, z."""
    targets: Array
    """(C, 3) points to look at."""

    @property
    def azimuths_rad(self) -> Array:
        """(C,) of the gaze."""
        gaze = self.targets[:, [0, 2]] - self.places
        return np.arctan2(gaze[:, 1], gaze[:, 0])

    def joined(self, other: "Candidates") -> "Candidates":
        """These, then others."""
        return Candidates(
            places=np.vstack([self.places, other.places]),
            targets=np.vstack([self.targets, other.targets]),
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Visibility:
    """The ground that lies open round some places."""

    places: Array
    """(C, 2) x, z."""
    field_rad: float
    """Width of a view."""
    reach: float
    """Distance up to which a view tells free ground, world units."""
    barred: Mask
    """(C, NUM_RAYS) views that nearly were taken before, and would show nothing more."""
    _cell: NDArray[np.intp]
    """(C, NUM_RAYS, R) cell under each sample of the rays; past the last where it is hidden."""
    _area: Array
    """(R,) area that each sample stands for, square world units."""

    @classmethod
    def over(cls, floor: Floor, places: Array, field_rad: float, reach: float) -> "Visibility":
        """Look out from every place (C, 2) as far as the mapped obstacles allow."""
        step = SAMPLE * floor.cell_size
        number = math.ceil(reach / step - 0.5 - ROUNDING)
        radii: Array = step * (np.arange(number, dtype=np.float64) + 0.5)
        lines = floor.lines(places, AZIMUTHS_RAD, radii)
        blocking = floor.occupied | floor.barred
        return cls(
            places=places,
            field_rad=field_rad,
            reach=reach,
            barred=np.zeros((len(places), NUM_RAYS), dtype=bool),
            _cell=np.where(floor.open_samples(lines, blocking), lines.cell, floor.occupied.size),
            _area=radii * step * SPACING_RAD,
        )

    def without(self, views: Iterable[tuple[Array, float]], same_place: float) -> "Visibility":
        """The same, with views barred that are near those from a place (2,) along an azimuth."""
        barred = self.barred.copy()
        for place, azimuth in views:
            is_near = np.hypot(*(self.places - place).T) <= same_place
            barred |= is_near[:, None] & (turn(AZIMUTHS_RAD, np.array(azimuth)) <= SAME_GAZE_RAD)
        return replace(self, barred=barred)

    def area(self, unknown: Mask) -> Array:
        """(C, NUM_RAYS) unknown area that a view along each azimuth would show."""
        of_ray = np.append(unknown.ravel(), False)[self._cell] @ self._area
        half = round(self.field_rad / SPACING_RAD / 2.0)
        wrapped = np.concatenate([of_ray[:, -half:], of_ray, of_ray[:, :half]], axis=1)
        window = np.lib.stride_tricks.sliding_window_view(wrapped, 2 * half + 1, axis=1)
        return np.where(self.barred, 0.0, window.sum(axis=-1))


def ray_of(azimuths_rad: Array) -> NDArray[np.intp]:
    """Number of the ray nearest to each azimuth."""
    ray: NDArray[np.intp] = np.rint(azimuths_rad / SPACING_RAD).astype(np.intp) % NUM_RAYS
    return ray


def new_sides(
    candidates: Candidates,
    obstacles: Iterable[Obstacle | Detection],
    floor: Floor,
    field_rad: float,
    reach: float,
) -> Array:
    """(C,) number of new sides of obstacles that each view would show; 1 is a wholly new one."""
    gain = np.zeros(len(candidates.places))
    for obstacle in obstacles:
        azimuth, distance = polar(obstacle.centre, candidates.places)
        is_near = distance - obstacle.radius <= reach
        is_ahead = turn(azimuth, candidates.azimuths_rad) <= field_rad / 2.0
        is_seen = is_near & is_ahead & _is_open(candidates.places, obstacle, floor)
        gain += np.where(is_seen, novelty(azimuth + np.pi, obstacle), 0.0)
    return gain


def turn(a_rad: Array, b_rad: Array) -> Array:
    """Smallest angle between directions, radians."""
    between: Array = np.abs(np.angle(np.exp(1j * (a_rad - b_rad))))
    return between


def novelty(bearings_rad: Array, obstacle: Obstacle | Detection) -> Array:
    """(C,) novelty of the sides that an obstacle shows to some bearings, 0 to 1."""
    seen = obstacle.bearings_rad if isinstance(obstacle, Obstacle) else np.empty(0)
    if not len(seen):
        return np.ones(len(bearings_rad))
    nearest = turn(bearings_rad[:, None], seen).min(axis=1) / NEW_SIDE_RAD
    return np.where(nearest < MIN_NOVELTY, 0.0, np.minimum(nearest, 1.0))


def _is_open(places: Array, obstacle: Obstacle | Detection, floor: Floor) -> Mask:
    """(C,) the places from which nothing stands between the cameras and an obstacle."""
    share = np.linspace(0.0, 1.0, 24)[:, None, None]
    points = places + share * (obstacle.centre - places)
    occupied = np.append(floor.occupied.ravel(), False)[floor.flat(floor.cells(points))]
    own = (
        np.hypot(*np.moveaxis(points - obstacle.centre, -1, 0)) <= obstacle.radius + floor.cell_size
    )
    free: Mask = ~(occupied & ~own).any(axis=0)
    return free
