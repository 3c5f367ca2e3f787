"""A scan: the floor seen by one pair, as rays that end at obstacles, and its detections."""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label, minimum_filter1d

from recon.exploration.feet import foot_distances
from recon.exploration.floor import NEIGHBOURS, Array, Floor
from recon.exploration.scales import Scales
from recon.geometry import wrapped
from recon.records import PointCloud, StereoPair, View

BLUR_RAD = math.radians(1.5)
"""Maximum angle between neighbouring points of one obstacle, which hides what is behind the
gaps."""
MARGIN = 1.0
"""Cells in front of an obstacle that stay unknown: half a cell and the thickness of an edge."""
MIN_POINTS = 8
"""Fewer points than this are noise ..."""
MIN_POINTS_DISTANCE = 6.0
"""... and so are fewer than the square of this over the distance in viewing distances: a quarter of
the typical features of a tree with a radius of 0.1 and a height of 0.4 viewing distances."""
COMPANY_DISTANCE, COMPANY = 2.0, (4.0, 40.0)
"""A point is noise if its group has fewer points than the square of this over the distance in
viewing distances, within these bounds."""
RANGE_RATIO = 1.15
"""Points in one direction whose distances differ by more than this factor belong to two
obstacles ..."""
NUM_SIGMAS = 2.0
"""... unless they differ by fewer standard deviations than this."""
MAY_BE_OFF: Array = np.linspace(-4.0, 4.0, 9)
"""Distances of an obstacle from where it was detected, in its standard deviations: they are half
those of its points, which may be the nearest or the farthest ones."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Scan:
    """One view over the floor."""

    place: Array
    """(2,) x, z of the point midway between the cameras."""
    azimuths_rad: Array
    """(A,) azimuths of the rays over the field of view, evenly spaced."""
    limits: Array
    """(A,) length of each ray, to an obstacle or to its end."""
    feet: Array
    """(A,) distance of the first foot of an obstacle on each ray; infinite = none."""

    def _inside(self, ray: NDArray[np.intp]) -> NDArray[np.bool_]:
        return (ray >= 0) & (ray < len(self.limits))

    def _ray(self, azimuth_rad: Array) -> NDArray[np.intp]:
        first, last = self.azimuths_rad[[0, -1]]
        spacing = (last - first) / (len(self.azimuths_rad) - 1)
        turned = np.mod(azimuth_rad - first + np.pi / 2, 2 * np.pi) - np.pi / 2
        ray: NDArray[np.intp] = np.rint(turned / spacing).astype(np.intp)
        return ray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Detection:
    """An obstacle seen from too far away, or too poorly, to be in the map."""

    centre: Array
    """(2,) x, z of the centre of its visible points."""
    radius: float
    """Half its width, world units."""
    distance: float
    """Distance from which it was seen, world units."""
    sigma: float
    """Standard deviation of that distance."""
    azimuth_rad: float = 0.0
    """Direction in which it was seen."""

    @property
    def places(self) -> Array:
        """(P, 2) x, z where its centre may be, within the errors of its points."""
        ahead = np.array([math.cos(self.azimuth_rad), math.sin(self.azimuth_rad)])
        places: Array = self.centre + np.outer(MAY_BE_OFF * self.sigma, ahead)
        return places

    def is_refuted(self, floor: Floor, place: Array | None = None) -> bool:
        """True if closer views saw the ground as free where it seems to be, or at a place (2,)."""
        where = self.centre if place is None else place
        return floor.is_free(where, self.radius, self.distance - self.radius)


def polar(points_xz: Array, place: Array) -> tuple[Array, Array]:
    """Azimuth (N,) in radians and distance (N,) of points (N, 2) from a position (2,)."""
    offset = points_xz - place
    return np.arctan2(offset[:, 1], offset[:, 0]), np.hypot(offset[:, 0], offset[:, 1])


def field_of_view(pair: StereoPair) -> float:
    """Horizontal field of view, radians."""
    return 2.0 * math.atan(pair.rig.width / 2.0 / pair.rig.focal_px)


def scan(
    view: View,
    pair: StereoPair,
    standing: PointCloud,
    reach: float,
    ground: tuple[float, float],
    floor: Floor,
) -> Scan:
    """Measure the free distance in all directions of a view.

    Parameters
    ----------
    standing : PointCloud
        Points of the pair above the ground, world.
    reach : float
        Distance up to which an obstacle is reliably seen, world units.
    ground : (float, float)
        Height of the ground, and distance at which it ends.
    floor : Floor
        The ground grid that the rays are for.
    """
    place = view.position[[0, 2]]
    heading = math.atan2(*(view.target[[2, 0]] - view.position[[2, 0]]))
    rays = floor.azimuths(heading, field_of_view(pair), reach)
    endless = np.full(len(rays), np.inf)
    open_field = Scan(
        place=place, azimuths_rad=rays, limits=np.full(len(rays), reach), feet=endless
    )
    azimuth, distance = polar(standing.points[:, [0, 2]], place)
    nearest = open_field.limits.copy()
    ray = open_field._ray(azimuth)
    inside = open_field._inside(ray)
    ends = np.maximum(distance - MARGIN * floor.cell_size - sigma_of(standing), 0.0)
    np.minimum.at(nearest, ray[inside], ends[inside])
    blur = 1 + 2 * round(BLUR_RAD / 2.0 / (rays[1] - rays[0]))
    limits = minimum_filter1d(nearest, blur, mode="nearest")
    feet = foot_distances(pair, rays, place, ground, floor)
    limits = np.minimum(limits, np.maximum(feet - MARGIN * floor.cell_size, 0.0))
    return Scan(place=place, azimuths_rad=rays, limits=limits, feet=feet)


def sigma_of(cloud: PointCloud) -> Array:
    """Depth sigma of every point; zero if unknown."""
    return np.zeros(len(cloud)) if cloud.sigma is None else cloud.sigma


def detections(cloud: PointCloud, place: Array, scales: Scales) -> list[Detection]:
    """Obstacles in a cloud: groups of points that are large enough.

    Points in none of them are grouped once more, as far apart as their errors allow: those of a
    small obstacle far away are too few for their spread.
    """
    azimuth, distance = polar(cloud.points[:, [0, 2]], place)
    side, ahead = _sideways(azimuth)
    sigma, reach = sigma_of(cloud), MIN_POINTS_DISTANCE * scales.viewing_distance
    found, left = [], np.arange(len(cloud))
    for steps in (range_steps(distance / scales.cell), _error_steps(distance, sigma)):
        group = groups(side[left], steps[left])
        for number in np.flatnonzero(np.bincount(group) >= MIN_POINTS):
            rows = left[group == number]
            if len(rows) >= max(MIN_POINTS, (reach / np.median(distance[rows])) ** 2):
                one = _detection(distance[rows], side[rows], sigma[rows], place, ahead)
                found.append(replace(one, radius=max(scales.cell, one.radius)))
                group[group == number] = -1
        left = left[group >= 0]
    return found


def without_noise(cloud: PointCloud, place: Array, scales: Scales) -> PointCloud:
    """The points without isolated ones: an obstacle has many points, more when it is closer."""
    azimuth, distance = polar(cloud.points[:, [0, 2]], place)
    group = groups(_sideways(azimuth)[0], range_steps(distance / scales.cell))
    size = np.bincount(group)[group]
    reach = COMPANY_DISTANCE * scales.viewing_distance
    return cloud.select(size >= np.clip((reach / distance) ** 2, *COMPANY))


def _sideways(azimuth: Array) -> tuple[Array, float]:
    """Azimuths relative to their mean direction, so that they do not wrap around, and the mean."""
    ahead = float(np.angle(np.exp(1j * azimuth).sum()))
    return wrapped(azimuth - ahead), ahead


def range_steps(distance_cells: Array) -> Array:
    """Steps (N,) of distance; one point in each of two neighbouring ones may be one obstacle.

    The logarithm of the distance is used, in which the stereo error grows slowest.
    """
    steps: Array = np.log(np.maximum(distance_cells, 1.0)) / math.log(RANGE_RATIO)
    return steps


def _error_steps(distance: Array, sigma: Array) -> Array:
    """The same where errors are large: steps (N,) of disparity, whose error is everywhere alike."""
    if not len(distance):
        return distance
    # The steps of the farthest points are at least as wide as those of range.
    least = math.log(RANGE_RATIO) / distance.max()
    growth = NUM_SIGMAS * np.median(sigma / distance**2)
    steps: Array = 1.0 / (max(growth, least) * distance)
    return steps


def groups(side: Array, steps: Array) -> NDArray[np.intp]:
    """Number of the group of each point: those that touch in direction and in steps of distance."""
    if not len(side):
        return np.empty(0, dtype=np.intp)
    column = np.floor(side / BLUR_RAD).astype(np.intp)
    row = np.floor(steps).astype(np.intp)
    column -= column.min()
    row -= row.min()
    grid = np.zeros((column.max() + 1, row.max() + 1), dtype=bool)
    grid[column, row] = True
    number, _ = label(grid, NEIGHBOURS)
    group: NDArray[np.intp] = number[column, row].astype(np.intp) - 1
    return group


def _detection(distance: Array, side: Array, sigma: Array, place: Array, ahead: float) -> Detection:
    middle = ahead + float(np.median(side))
    away = float(np.median(distance))
    return Detection(
        centre=place + away * np.array([math.cos(middle), math.sin(middle)]),
        distance=away,
        radius=away * math.tan(float(np.ptp(side)) / 2.0),
        # Errors of an obstacle's points are correlated, so their mean improves by less than
        # sqrt(N).
        sigma=float(np.median(sigma)) / 2.0,
        azimuth_rad=middle,
    )
