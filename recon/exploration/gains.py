"""Ground that views would show, from many positions at once."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

from recon.exploration import sight
from recon.exploration.floor import RAY_SPACING, ROUNDING, Array, Floor, Mask

NUM_RAYS = 90
SPACING_RAD = 2.0 * math.pi / NUM_RAYS
AZIMUTHS_RAD: Array = np.linspace(0.0, 2.0 * math.pi, NUM_RAYS, endpoint=False)
SAMPLE = 2.0
"""Cells between two samples along a ray; less than half an obstacle's width."""
SAME_GAZE_RAD = 4.5 * SPACING_RAD
"""A view from the same position, rotated by at most this angle, shows nothing new."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Visibility:
    """The visible ground around some positions."""

    floor: Floor
    blocking: Mask
    """(X, Z) cells that block the view."""
    places: Array
    """(C, 2) x, z."""
    field_rad: float
    """Width of a view."""
    reach: float
    """Distance up to which a view recognises free ground, world units."""
    barred: Mask
    """(C, NUM_RAYS) views similar to earlier ones, which would show nothing new."""
    _rays: sight.Rays
    """Unknown cells along each of NUM_RAYS rays."""
    _area: Array
    """(R,) area that each sample represents, square world units."""

    @classmethod
    def over(
        cls, floor: Floor, places: Array, field_rad: float, reach: float, unknown: Mask
    ) -> "Visibility":
        """The view from every position (C, 2) of unknown cells (X, Z), up to the obstacles."""
        number = math.ceil(reach / (SAMPLE * floor.cell_size) - 0.5 - ROUNDING)
        radii: Array = SAMPLE * (np.arange(number, dtype=np.float64) + 0.5)
        blocking = floor.occupied | floor.barred
        return cls(
            floor=floor,
            blocking=blocking,
            places=places,
            field_rad=field_rad,
            reach=reach,
            barred=np.zeros((len(places), NUM_RAYS), dtype=bool),
            _rays=sight.cast(
                blocking, unknown.ravel(), floor.in_cells(places), AZIMUTHS_RAD, radii
            ),
            _area=radii * SAMPLE * SPACING_RAD * floor.cell_size**2,
        )

    def without(self, views: Sequence[tuple[Array, float]], same_place: float) -> "Visibility":
        """The same, without views similar to those from positions (2,) along azimuths."""
        barred = self.barred.copy()
        apart = cdist(self.places, np.array([place for place, _ in views]).reshape(-1, 2))
        near, view = np.nonzero(apart <= same_place * (1.0 + ROUNDING))
        azimuths = np.array([azimuth for _, azimuth in views], dtype=np.float64)[view]
        np.logical_or.at(barred, near, turn(AZIMUTHS_RAD, azimuths[:, None]) <= SAME_GAZE_RAD)
        return replace(self, barred=barred)

    def only(self, places: Mask) -> "Visibility":
        """The same, without views from any but some of the positions (C,)."""
        return replace(self, barred=self.barred | ~places[:, None])

    def area(self, unknown: Mask, rows: NDArray[np.intp] | None = None) -> Array:
        """Area (C, NUM_RAYS) that a view along each azimuth would show of what is still unknown.

        If `rows` is given, only for these positions; zero for others.
        """
        places = np.arange(len(self.places)) if rows is None else rows
        area = sight.fields(self._rays, places, unknown.ravel(), self._area, self._half)
        return np.where(self.barred, 0.0, area)

    def best(self, unknown: Mask) -> sight.Best:
        """The view from each position that shows most of what is still unknown."""
        best: sight.Best = sight.best_fields(
            self._rays, unknown.ravel(), self._area, self._half, self.barred
        )
        return best

    def best_place(
        self, unknown: Mask, best: sight.Best, cost: Array, least: Array
    ) -> tuple[int, int] | None:
        """The position and ray of the view that shows most for its cost; None = not enough.

        Parameters
        ----------
        best : sight.Best
            The best views while more was unknown; updated in place.
        cost, least : (C,), (C,)
            Cost of each position, and the area that a view from it has to show.
        """
        place = sight.best_place(
            self._rays, unknown.ravel(), self._area, self._half, self.barred, best, (cost, least)
        )
        return None if place < 0 else (int(place), int(best[1][place]))

    @property
    def _half(self) -> int:
        """Rays on either side of the middle of a view."""
        return round(self.field_rad / SPACING_RAD / 2.0)

    def left(self, unknown: Mask, place: Array, azimuth_rad: float) -> Mask:
        """The unknown cells (X, Z) that a view from a position (2,) would not show."""
        rays = self.floor.azimuths(azimuth_rad, self.field_rad, self.reach)
        number = round(self.reach / self.floor.cell_size / RAY_SPACING)
        radii, left = RAY_SPACING * np.arange(number), unknown.copy()
        sight.see(left.ravel(), self.blocking, self.floor.in_cells(place), rays, radii)
        return left


def turn(a_rad: Array, b_rad: Array) -> Array:
    """Smallest angle between directions, radians."""
    between: Array = np.abs(np.mod(a_rad - b_rad + np.pi, 2.0 * np.pi) - np.pi)
    return between
