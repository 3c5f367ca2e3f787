"""A round of views that shows all unknown ground for a short way."""

import numpy as np
from numpy.typing import NDArray

from recon.exploration.floor import Array, Floor, Mask, first_best
from recon.exploration.gains import AZIMUTHS_RAD, Visibility
from recon.exploration.scales import Scales


def first_stop(
    floor: Floor, unknown: Mask, visibility: Visibility, start: Array, scales: Scales
) -> tuple[Array, float] | None:
    """The place (2,) and azimuth of the view that a round begins with; None where there is none.

    The view that shows most for its detour is put into the round where that is shortest, what it
    would show is taken for seen, and so on until no view shows enough.
    """
    points, gazes = start[None], [0.0]
    while True:
        area = visibility.area(unknown)
        shown = area.max(axis=1)
        detour, position = insertion(points, visibility.places)
        score = np.where(shown >= scales.min_area, shown, 0.0) / (detour + scales.stop_cost)
        best = int(first_best(score))
        if score[best] == 0.0:
            return (points[1], gazes[1]) if len(points) > 1 else None
        place, gaze = visibility.places[best], float(AZIMUTHS_RAD[first_best(area[best])])
        points = np.insert(points, position[best], place, axis=0)
        gazes.insert(int(position[best]), gaze)
        unknown = unknown & ~_shown(floor, visibility, place, gaze)
        visibility = visibility.without([(place, gaze)], scales.same_place)


def _shown(floor: Floor, visibility: Visibility, place: Array, gaze: float) -> Mask:
    """(X, Z) the cells that a view would show."""
    rays = floor.azimuths(gaze, visibility.field_rad, visibility.reach)
    return np.isfinite(floor.visible(place, rays, np.full(len(rays), visibility.reach)))


def insertion(points: Array, places: Array) -> tuple[Array, NDArray[np.intp]]:
    """The detour by which an open path (P, 2) gets longer for each place (C, 2).

    Returns
    -------
    detour : (C,) float64
        World units, as the crow flies.
    position : (C,) int
        Number of the place on the new path, 1 to P: the path goes on beginning where it begins.
    """
    leg = np.linalg.norm(places[:, None] - points, axis=-1)
    along = np.linalg.norm(np.diff(points, axis=0), axis=1)
    detour = np.concatenate([leg[:, :-1] + leg[:, 1:] - along, leg[:, -1:]], axis=1)
    return detour.min(axis=1), first_best(-detour, axis=1) + 1
