"""A round of views that shows all unknown ground for a short way."""

import numpy as np
from numpy.typing import NDArray

from recon.exploration.floor import Array, Floor, Mask, azimuths
from recon.exploration.gains import AZIMUTHS_RAD, Outlook

STOP_COST = 30.0
"""A stop costs as much as walking this far, world units."""
MIN_CELLS = 40.0
"""A view that shows fewer unknown cells than this is not worth a stop."""


def first_stop(
    floor: Floor, unknown: Mask, outlook: Outlook, start: Array
) -> tuple[Array, float] | None:
    """Place (2,) and azimuth of the view that a round begins with; None where there is none.

    The view that shows most for its detour is put into the round where that is shortest, what it
    would show is taken for seen, and so on until no view shows enough.
    """
    points, gazes = start[None], [0.0]
    while True:
        cells = outlook.cells(unknown)
        shown = cells.max(axis=1)
        detour, position = insertion(points, outlook.places)
        score = np.where(shown >= MIN_CELLS, shown, 0.0) / (detour + STOP_COST)
        best = int(score.argmax())
        if score[best] == 0.0:
            return (points[1], gazes[1]) if len(points) > 1 else None
        place, gaze = outlook.places[best], float(AZIMUTHS_RAD[cells[best].argmax()])
        points = np.insert(points, position[best], place, axis=0)
        gazes.insert(int(position[best]), gaze)
        unknown = unknown & ~_shown(floor, outlook, place, gaze)
        outlook = outlook.without([(place, gaze)])


def _shown(floor: Floor, outlook: Outlook, place: Array, gaze: float) -> Mask:
    """(X, Z) the cells that a view would show."""
    rays = azimuths(gaze, outlook.field_rad, outlook.reach)
    return np.isfinite(floor.visible(place, rays, np.full(len(rays), outlook.reach)))


def insertion(points: Array, places: Array) -> tuple[Array, NDArray[np.intp]]:
    """How much longer an open way (P, 2) gets by each place (C, 2), and where it is put in.

    Returns
    -------
    detour : (C,) float64
        World units, as the crow flies.
    position : (C,) int
        Its number on the new way, 1 to P: the way goes on beginning where it begins.
    """
    leg = np.linalg.norm(places[:, None] - points, axis=-1)
    along = np.linalg.norm(np.diff(points, axis=0), axis=1)
    detour = np.concatenate([leg[:, :-1] + leg[:, 1:] - along, leg[:, -1:]], axis=1)
    return detour.min(axis=1), detour.argmin(axis=1) + 1
