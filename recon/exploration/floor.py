"""The ground grid: the agent's knowledge of the floor, cell by cell: free, occupied or unknown."""

import math
from copy import copy
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from recon.errors import InputError
from recon.settings import Settings

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

RAY_SPACING = 0.5
"""Cells between two rays at their far ends, and between two samples along one, so that no cell is
missed."""
NEIGHBOURS: Mask = np.ones((3, 3), dtype=bool)
"""A cell and its eight neighbours."""
MAX_CELLS = 16_000_000
"""Maximum number of floor cells: planning needs some hundred bytes per cell."""
MAX_REACH_CELLS = 1000.0
"""Range of sight that a smaller floor may have: a view takes memory by the square of it."""
MIN_RADIUS_SHARE = 1e-7
"""Smallest radius of the body relative to the floor: its way is sampled in steps of the radius."""
MIN_HITS = 2
"""Number of points of one view on a cell that show an obstacle: a lone one may be noise."""
MUCH_NEARER = 2.0
"""Factor between two distances of which the smaller one counts alone: errors of depth grow with the
square of the distance, and thin obstacles disappear."""
ROUNDING = 1e-9
"""Numbers with a smaller difference are equal, so that decisions do not depend on the unit of
length."""


def check_floor(settings: Settings) -> None:
    """Raise `InputError` if the floor, a view of it or a way over it is too much for memory."""
    shape = _shape(settings.world.size_x, settings.world.size_z, settings.map.cell_size)
    longest = max(MAX_REACH_CELLS, math.hypot(*shape)) * settings.map.cell_size
    for name, value in (
        ("exploration.sight_range", settings.exploration.sight_range),
        ("motion.position_noise", settings.motion.position_noise),
    ):
        if value > longest:
            raise InputError(
                f"{name} is {value:g}, but at most {longest:g} is possible with this floor and "
                "map.cell_size"
            )
    radius, least = settings.motion.body_radius, MIN_RADIUS_SHARE * longest
    if radius < least:
        raise InputError(
            f"motion.body_radius is {radius:g}, but at least {least:g} is needed on this floor"
        )


def _shape(size_x: float, size_z: float, cell_size: float) -> tuple[int, int]:
    """Number of cells along x and z."""
    shape = [math.ceil(size / cell_size - ROUNDING) for size in (size_x, size_z)]
    if math.prod(shape) > MAX_CELLS:
        raise InputError(
            f"the floor (world.size_x, world.size_z) is {shape[0]:.6g} x {shape[1]:.6g} cells of "
            f"map.cell_size, but at most {MAX_CELLS} cells can be explored"
        )
    return max(1, shape[0]), max(1, shape[1])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Lines:
    """Lines of sight over the floor from C positions, sampled outwards."""

    cell: NDArray[np.intp]
    """(C, A, R) flat index of the cell under each sample; one past the last = off the floor."""
    radii: Array
    """(R,) distance of the samples from the position, world units."""


@dataclass(slots=True, kw_only=True, eq=False)
class Floor:
    """Square cells around the origin; the agent's flat map."""

    size_x: float
    size_z: float
    cell_size: float = 1.0
    """World units, like the sizes."""
    corner: Array = field(init=False)
    """(2,) x, z of its lowest corner."""
    seen_from: Array = field(init=False)
    """(X, Z) smallest distance from which a view saw the cell as free; infinite = never."""
    barred_from: Array = field(init=False)
    """(X, Z) smallest distance from which the foot of an obstacle was seen on it."""
    hit_from: Array = field(init=False)
    """(X, Z) smallest distance from which points of an obstacle were seen above it."""
    occupied: Mask = field(init=False)
    """(X, Z) True if a mapped obstacle is on or above the cell."""
    touched: Mask = field(init=False)
    """(X, Z) True if the body would collide with something there, seen or not."""

    def __post_init__(self) -> None:
        shape = _shape(self.size_x, self.size_z, self.cell_size)
        self.corner = -np.array([self.size_x, self.size_z]) / 2.0
        self.seen_from = np.full(shape, np.inf)
        self.barred_from = np.full(shape, np.inf)
        self.hit_from = np.full(shape, np.inf)
        self.occupied = np.zeros(shape, dtype=bool)
        self.touched = np.zeros(shape, dtype=bool)

    @property
    def shape(self) -> tuple[int, int]:
        """Number of cells along x and z."""
        return self.occupied.shape[0], self.occupied.shape[1]

    @property
    def known_free(self) -> Mask:
        """(X, Z) within some view's field and range with no obstacle in front."""
        return np.isfinite(self.seen_from) & ~self.barred

    @property
    def known_share(self) -> float:
        """Share of the cells that are known: free, barred or occupied."""
        return float((self.known_free | self.barred | self.occupied).mean())

    @property
    def barred(self) -> Mask:
        """(X, Z) a foot was seen on it, and no view closer by more than a cell saw it as free."""
        nearest_free = self.seen_from + self.cell_size
        return np.isfinite(self.barred_from) & (self.barred_from <= nearest_free)

    @property
    def hit(self) -> Mask:
        """(X, Z) points were seen above it, and only views from much farther saw it as free.

        These may be too few points for the map, like those on the end of a fence.
        """
        return np.isfinite(self.hit_from) & (MUCH_NEARER * self.hit_from <= self.seen_from)

    def window(self, place_xz: Array, reach: float) -> "Floor":
        """The part of the floor within reach of a position along x and z; it shares the arrays."""
        low = self.cells(place_xz - reach).clip(0, self.shape)
        high = (self.cells(place_xz + reach) + 1).clip(low, self.shape)
        part, rows = copy(self), tuple(map(slice, low, high))
        part.corner = self.corner + low * self.cell_size
        part.size_x, part.size_z = (high - low) * self.cell_size
        part.seen_from, part.barred_from = self.seen_from[rows], self.barred_from[rows]
        part.hit_from, part.occupied = self.hit_from[rows], self.occupied[rows]
        part.touched = self.touched[rows]
        return part

    def cells(self, points_xz: ArrayLike) -> NDArray[np.intp]:
        """Cell (..., 2) of each point (..., 2); it may be off the floor."""
        return np.floor(self.in_cells(points_xz) + ROUNDING).astype(np.intp)

    def centres(self, cells: ArrayLike) -> Array:
        """Centres x, z (..., 2) of cells (..., 2)."""
        centres: Array = (np.asarray(cells) + 0.5) * self.cell_size + self.corner
        return centres

    def in_cells(self, points_xz: ArrayLike) -> Array:
        """Positions (..., 2) of points (..., 2) in cells, relative to the floor's corner."""
        places: Array = (np.asarray(points_xz) - self.corner) / self.cell_size
        return places

    def holds(self, cells: NDArray[np.intp]) -> Mask:
        """Mask of the cells (..., 2) on the floor."""
        x, z = cells[..., 0], cells[..., 1]
        inside: Mask = (x >= 0) & (x < self.shape[0]) & (z >= 0) & (z < self.shape[1])
        return inside

    def flat(self, cells: NDArray[np.intp]) -> NDArray[np.intp]:
        """Flat index of each cell (..., 2), row by row; one past the last if off the floor."""
        number = cells[..., 0] * self.shape[1] + cells[..., 1]
        return np.where(self.holds(cells), number, self.occupied.size)

    def mask(self, points_xz: ArrayLike) -> Mask:
        """Mask (X, Z) of the cells with at least one of the points (N, 2)."""
        cells = self.cells(points_xz)
        marked = np.zeros(self.shape, dtype=bool)
        marked[tuple(cells[self.holds(cells)].T)] = True
        return marked

    def disc(self, centre_xz: Array, radius: float) -> Mask:
        """Mask (X, Z) of the cells whose centre is in a disc."""
        low = self.cells(centre_xz - radius).clip(0, self.shape)
        high = (self.cells(centre_xz + radius) + 1).clip(0, self.shape)
        x, z = (
            (np.arange(first, end) + 0.5) * self.cell_size + corner
            for first, end, corner in zip(low, high, self.corner, strict=True)
        )
        near = np.zeros(self.shape, dtype=bool)
        box = tuple(map(slice, low, high))
        near[box] = np.hypot(x[:, None] - centre_xz[0], z - centre_xz[1]) <= radius
        return near

    def is_free(self, centre_xz: Array, radius: float, distance: float) -> bool:
        """True if most of a disc is off the floor or free in a view from less than a distance."""
        around = self.window(centre_xz, radius)
        seen_from = around.seen_from[around.disc(centre_xz, radius)]
        return not len(seen_from) or bool(np.median(seen_from) < distance)

    def lines(self, places_xz: ArrayLike, azimuths_rad: Array, radii: Array) -> Lines:
        """Lines of sight from positions (C, 2) along every azimuth (A,)."""
        directions = np.column_stack([np.cos(azimuths_rad), np.sin(azimuths_rad)])
        places = np.asarray(places_xz, dtype=np.float64)
        samples = places[:, None, None] + directions[:, None] * radii[:, None]
        return Lines(cell=self.flat(self.cells(samples)), radii=radii)

    def open_samples(self, lines: Lines, blocking: Mask) -> Mask:
        """Mask (C, A, R) of the samples on the floor with no blocking cell (X, Z) before them.

        Obstacles above the position itself do not hide the floor around it.
        """
        blocked = np.append(blocking.ravel(), True)[lines.cell]
        came_out = np.logical_or.accumulate(~blocked, axis=-1)
        clear: Mask = ~np.logical_or.accumulate(blocked & came_out, axis=-1) & came_out
        return clear

    def visible(self, place_xz: Array, azimuths_rad: Array, limits: Array) -> Array:
        """Distance (X, Z) of the cells in front of mapped obstacles and within `limits` (A,).

        Infinite if a cell is not seen.
        """
        step = RAY_SPACING * self.cell_size
        radii = step * np.arange(math.ceil(limits.max(initial=0.0) / step - ROUNDING))
        lines = self.lines(place_xz[None], azimuths_rad, radii)
        seen = self.open_samples(lines, self.occupied)[0] & (radii < limits[:, None])
        distance = np.full(self.occupied.size, np.inf)
        np.minimum.at(distance, lines.cell[0][seen], np.broadcast_to(radii, seen.shape)[seen])
        return distance.reshape(self.shape)

    def see(self, place_xz: Array, azimuths_rad: Array, limits: Array) -> None:
        """Record the free ground that a view shows."""
        part = self.window(place_xz, limits.max(initial=0.0))
        seen_from = part.visible(place_xz, azimuths_rad, limits)
        np.minimum(part.seen_from, seen_from, out=part.seen_from)

    def bar(self, place_xz: Array, azimuths_rad: Array, distances: Array) -> None:
        """Record the feet of obstacles that a view shows; infinite = none."""
        seen = np.isfinite(distances)
        azimuth, distance = azimuths_rad[seen], distances[seen]
        offsets = distance[:, None] * np.column_stack([np.cos(azimuth), np.sin(azimuth)])
        cells = self.cells(place_xz + offsets)
        inside = self.holds(cells)
        np.minimum.at(self.barred_from, tuple(cells[inside].T), distance[inside])

    def hit_at(self, place_xz: Array, points_xz: Array) -> None:
        """Record the cells with enough of the reliable points (N, 2) that a view shows."""
        cells = self.cells(points_xz)
        cells, number = np.unique(cells[self.holds(cells)], axis=0, return_counts=True)
        cells = cells[number >= MIN_HITS]
        distance = np.hypot(*(self.centres(cells) - place_xz).T)
        np.minimum.at(self.hit_from, tuple(cells.T), distance)

    def touch(self, place_xz: Array, radius: float) -> bool:
        """Record that a body of some radius cannot stand at a position; False if nothing is new."""
        disc = self.disc(place_xz, radius + self.cell_size)
        is_new = not self.touched[disc].all()
        self.touched |= disc
        return is_new

    def azimuths(self, heading_rad: float, field_rad: float, reach: float) -> Array:
        """Azimuths of rays over a field of view that hit every cell within `reach`.

        The azimuth of a direction (x, z) is atan2(z, x): it increases clockwise seen from above.
        """
        number = 2 + math.ceil(field_rad * reach / (RAY_SPACING * self.cell_size))
        return heading_rad + np.linspace(-field_rad / 2.0, field_rad / 2.0, number)


def first_best(values: Array) -> int:
    """Index of the first maximum of values (N,), independent of rounding."""
    slack = ROUNDING * np.abs(values).max(initial=0.0)
    return int((values >= values.max() - slack).argmax())
