"""What one pair shows over the floor: the open field before the eyes, and things in it."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label, minimum_filter1d

from recon.exploration.floor import NEIGHBOURS, Array, azimuths
from recon.records import PointCloud, StereoPair, View

BLUR_RAD = math.radians(1.5)
"""A thing's points are this far apart at most: gaps between them hide what is behind, too."""
MARGIN = 1.0
"""World units before a thing that are left unknown: half a cell and the thickness of an edge."""
MIN_POINTS = 8
"""Fewer points than this are noise, not a thing ..."""
MIN_POINTS_DISTANCE = 120.0
"""... nor are fewer than the square of this over the distance: a tree of two units' radius and
eight units' height, of which a quarter of the usual features are found."""
COMPANY_DISTANCE, COMPANY = 40.0, (4.0, 40.0)
"""A point is noise where fewer than the square of this over the distance hang together with it,
within these bounds."""
RANGE_RATIO = 1.15
"""Points of one direction whose distances differ by more than this factor are of two things."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sight:
    """One look over the floor."""

    place: Array
    """(2,) x, z of the point midway between the eyes."""
    azimuths_rad: Array
    """(A,) of the rays over the field of view, evenly spaced."""
    limits: Array
    """(A,) how far each ray goes before it meets a thing or ends."""

    def _inside(self, ray: NDArray[np.intp]) -> NDArray[np.bool_]:
        return (ray >= 0) & (ray < len(self.limits))

    def _ray(self, azimuth_rad: Array) -> NDArray[np.intp]:
        first, last = self.azimuths_rad[[0, -1]]
        spacing = (last - first) / (len(self.azimuths_rad) - 1)
        turned = np.mod(azimuth_rad - first + np.pi / 2, 2 * np.pi) - np.pi / 2
        ray: NDArray[np.intp] = np.rint(turned / spacing).astype(np.intp)
        return ray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sighting:
    """Something seen too far off, or too poorly, to be in the map."""

    centre: Array
    """(2,) x, z of the middle of its visible points."""
    radius: float
    """Half its width, world units."""
    distance: float
    """How far off it was seen, world units."""
    sigma: float
    """Standard deviation of that distance."""


def polar(points_xz: Array, place: Array) -> tuple[Array, Array]:
    """Azimuth (N,) in radians and distance (N,) of points (N, 2) from a place (2,)."""
    offset = points_xz - place
    return np.arctan2(offset[:, 1], offset[:, 0]), np.hypot(offset[:, 0], offset[:, 1])


def field_of_view(pair: StereoPair) -> float:
    """Width of the field, radians."""
    return 2.0 * math.atan(pair.rig.width / 2.0 / pair.rig.focal_px)


def look(view: View, pair: StereoPair, things: PointCloud, reach: float) -> Sight:
    """How far the field of a view is open.

    Parameters
    ----------
    things : PointCloud
        Points of the pair above the ground, world.
    reach : float
        How far off a thing is surely seen, world units.
    """
    place = view.position[[0, 2]]
    heading = math.atan2(*(view.target[[2, 0]] - view.position[[2, 0]]))
    rays = azimuths(heading, field_of_view(pair), reach)
    sight = Sight(place=place, azimuths_rad=rays, limits=np.full(len(rays), reach))
    azimuth, distance = polar(things.points[:, [0, 2]], place)
    nearest = sight.limits.copy()
    ray = sight._ray(azimuth)
    inside = sight._inside(ray)
    ends = np.maximum(distance - MARGIN - sigma_of(things), 0.0)
    np.minimum.at(nearest, ray[inside], ends[inside])
    blur = 1 + 2 * round(BLUR_RAD / 2.0 / (rays[1] - rays[0]))
    limits = minimum_filter1d(nearest, blur, mode="nearest")
    return Sight(place=place, azimuths_rad=rays, limits=limits)


def sigma_of(cloud: PointCloud) -> Array:
    """Depth sigma of every point; zero where nothing is known of it."""
    return np.zeros(len(cloud)) if cloud.sigma is None else cloud.sigma


def sightings(cloud: PointCloud, place: Array) -> list[Sighting]:
    """Things in a cloud: groups of points that are large enough."""
    azimuth, distance = polar(cloud.points[:, [0, 2]], place)
    side, ahead = _sideways(azimuth)
    sigma, group = sigma_of(cloud), _groups(side, distance)
    found = []
    for number in range(group.max(initial=-1) + 1):
        rows = group == number
        if rows.sum() >= max(MIN_POINTS, (MIN_POINTS_DISTANCE / np.median(distance[rows])) ** 2):
            found.append(_sighting(distance[rows], side[rows], sigma[rows], place, ahead))
    return found


def without_noise(cloud: PointCloud, place: Array) -> PointCloud:
    """The points that are not alone: a thing shows many, the more the nearer it is."""
    azimuth, distance = polar(cloud.points[:, [0, 2]], place)
    group = _groups(_sideways(azimuth)[0], distance)
    size = np.bincount(group)[group]
    return cloud.select(size >= np.clip((COMPANY_DISTANCE / distance) ** 2, *COMPANY))


def _sideways(azimuth: Array) -> tuple[Array, float]:
    """Azimuths counted from their mean direction, so that they do not wrap round; and that."""
    ahead = float(np.angle(np.exp(1j * azimuth).sum()))
    return np.angle(np.exp(1j * (azimuth - ahead))), ahead


def _groups(side: Array, distance: Array) -> NDArray[np.intp]:
    """Number of the group of each point: those that touch in direction and distance.

    Distance is taken by its logarithm, in which the error of stereo grows slowest.
    """
    if not len(side):
        return np.empty(0, dtype=np.intp)
    column = np.floor(side / BLUR_RAD).astype(np.intp)
    row = np.floor(np.log(np.maximum(distance, MARGIN)) / math.log(RANGE_RATIO)).astype(np.intp)
    column -= column.min()
    row -= row.min()
    grid = np.zeros((column.max() + 1, row.max() + 1), dtype=bool)
    grid[column, row] = True
    number, _ = label(grid, NEIGHBOURS)
    group: NDArray[np.intp] = number[column, row].astype(np.intp) - 1
    return group


def _sighting(distance: Array, side: Array, sigma: Array, place: Array, ahead: float) -> Sighting:
    middle = ahead + float(np.median(side))
    away = float(np.median(distance))
    return Sighting(
        centre=place + away * np.array([math.cos(middle), math.sin(middle)]),
        distance=away,
        radius=max(1.0, away * math.tan(float(np.ptp(side)) / 2.0)),
        # Errors of one thing's points are not independent: their mean gains less than sqrt(N).
        sigma=float(np.median(sigma)) / 2.0,
    )
