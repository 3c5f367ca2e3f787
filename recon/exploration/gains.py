"""What views would add: ground nobody has seen, and sides of things nobody has looked at."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from recon.exploration.floor import Array, Floor, Mask
from recon.exploration.sight import Sighting, polar
from recon.exploration.things import Thing

NUM_RAYS = 90
SPACING_RAD = 2.0 * math.pi / NUM_RAYS
AZIMUTHS_RAD: Array = np.linspace(0.0, 2.0 * math.pi, NUM_RAYS, endpoint=False)
SAMPLE = 2.0
"""World units between two samples along a ray; less than half a thing's width."""
NEW_SIDE_RAD = np.radians(90.0)
"""A bearing this far from all earlier ones shows a wholly new side of a thing."""
SAME_PLACE, SAME_GAZE_RAD = 3.0, math.radians(20.0)
"""A view nearer than both to an earlier one shows nothing that the earlier one did not."""
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
class Outlook:
    """The ground that lies open round some places."""

    places: Array
    """(C, 2) x, z."""
    field_rad: float
    """Width of a view."""
    reach: float
    """How far a view tells free ground, world units."""
    barred: Mask
    """(C, NUM_RAYS) views that nearly were taken before, and would show nothing more."""
    _cell: NDArray[np.intp]
    """(C, NUM_RAYS, R) cell under each sample of the rays; past the last where it is hidden."""
    _area: Array
    """(R,) cells that each sample stands for."""

    @classmethod
    def over(cls, floor: Floor, places: Array, field_rad: float, reach: float) -> "Outlook":
        """Look out from every place (C, 2) as far as the mapped things allow."""
        radii: Array = np.arange(SAMPLE / 2.0, reach, SAMPLE)
        lines = floor.lines(places, AZIMUTHS_RAD, radii)
        return cls(
            places=places,
            field_rad=field_rad,
            reach=reach,
            barred=np.zeros((len(places), NUM_RAYS), dtype=bool),
            _cell=np.where(floor.open_samples(lines), lines.cell, floor.occupied.size),
            _area=radii * SAMPLE * SPACING_RAD,
        )

    def without(self, views: Iterable[tuple[Array, float]]) -> "Outlook":
        """The same, with the views near those from a place (2,) along an azimuth barred."""
        barred = self.barred.copy()
        for place, azimuth in views:
            is_near = np.hypot(*(self.places - place).T) <= SAME_PLACE
            barred |= is_near[:, None] & (turn(AZIMUTHS_RAD, np.array(azimuth)) <= SAME_GAZE_RAD)
        return replace(self, barred=barred)

    def cells(self, unknown: Mask) -> Array:
        """(C, NUM_RAYS) how many unknown cells a view along each azimuth would show."""
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
    things: Iterable[Thing | Sighting],
    floor: Floor,
    field_rad: float,
    reach: float,
) -> Array:
    """(C,) how many new sides of things each view would show; 1 is a wholly new one."""
    gain = np.zeros(len(candidates.places))
    for thing in things:
        azimuth, distance = polar(thing.centre, candidates.places)
        is_near = distance - thing.radius <= reach
        is_ahead = turn(azimuth, candidates.azimuths_rad) <= field_rad / 2.0
        is_seen = is_near & is_ahead & _is_open(candidates.places, thing, floor)
        gain += np.where(is_seen, novelty(azimuth + np.pi, thing), 0.0)
    return gain


def turn(a_rad: Array, b_rad: Array) -> Array:
    """Smallest angle between directions, radians."""
    between: Array = np.abs(np.angle(np.exp(1j * (a_rad - b_rad))))
    return between


def novelty(bearings_rad: Array, thing: Thing | Sighting) -> Array:
    """(C,) how new the sides are that a thing shows to some bearings, 0 to 1."""
    seen = thing.bearings_rad if isinstance(thing, Thing) else np.empty(0)
    if not len(seen):
        return np.ones(len(bearings_rad))
    nearest = turn(bearings_rad[:, None], seen).min(axis=1) / NEW_SIDE_RAD
    return np.where(nearest < MIN_NOVELTY, 0.0, np.minimum(nearest, 1.0))


def _is_open(places: Array, thing: Thing | Sighting, floor: Floor) -> Mask:
    """(C,) from which places nothing stands between the eyes and a thing."""
    share = np.linspace(0.0, 1.0, 24)[:, None, None]
    points = places + share * (thing.centre - places)
    occupied = np.append(floor.occupied.ravel(), False)[floor.flat(floor.cells(points))]
    own = np.hypot(*np.moveaxis(points - thing.centre, -1, 0)) <= thing.radius + 1.0
    free: Mask = ~(occupied & ~own).any(axis=0)
    return free
