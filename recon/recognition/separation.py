"""Two objects in one component: parted where two fits explain it better than one."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from recon.recognition.naming import Naming
from recon.records import UNKNOWN, Voxels

Array = NDArray[np.float64]
Piece = tuple[Naming, NDArray[np.intp]]

LONG = 1.5
"""Length over width of a footprint, in standard deviations, from which it may be two objects."""
MOST_OBJECTS = 8
"""Of one component: bounds the work on the cells of a street or a wall."""


def separate(
    voxels: Voxels, whole: Naming, min_voxels: int, name: Callable[[Voxels], Naming]
) -> list[Piece]:
    """The objects of a component with their rows: one, or more where more fit better.

    Parameters
    ----------
    whole : Naming
        What the component is as one object.
    min_voxels : int
        Smallest object.
    name : Callable
        Names the cells of one object.
    """
    waiting: list[Piece] = [(whole, np.arange(len(voxels)))]
    done: list[Piece] = []
    while waiting:
        naming, rows = waiting.pop()
        halves = None
        if len(waiting) + len(done) + 2 <= MOST_OBJECTS:
            halves = _halves(voxels.select(rows), naming, min_voxels, name)
        if halves is None:
            done.append((naming, rows))
        else:
            waiting.extend((half, rows[own]) for half, own in halves)
    return done


def _halves(
    voxels: Voxels, whole: Naming, min_voxels: int, name: Callable[[Voxels], Naming]
) -> list[Piece] | None:
    """Two objects that explain the cells better than `whole`; None where none do."""
    floor = voxels.means[:, ::2]
    if whole.label != UNKNOWN and _elongation(floor) < LONG:
        return None
    second = _two_means(floor)
    pieces = [np.flatnonzero(second == side) for side in (False, True)]
    if min(map(len, pieces)) < min_voxels:
        return None
    halves = [(name(voxels.select(own)), own) for own in pieces]
    if all(half.label == UNKNOWN for half, _ in halves):
        return None
    better = sum(half.deviance for half, _ in halves) < whole.deviance
    return halves if better else None


def _elongation(floor: Array) -> float:
    values = np.linalg.eigvalsh(np.cov(floor.T))
    return float(np.sqrt(values[1] / max(values[0], 1e-12)))


def _two_means(floor: Array) -> NDArray[np.bool_]:
    """Which side of a footprint's waist each cell is on, from the ends of its longer axis."""
    axis = np.linalg.eigh(np.cov(floor.T))[1][:, 1]
    along = floor @ axis
    centres = np.stack(
        [
            floor[along <= np.quantile(along, 0.1)].mean(axis=0),
            floor[along >= np.quantile(along, 0.9)].mean(axis=0),
        ]
    )
    second = np.zeros(len(floor), dtype=bool)
    for _ in range(20):
        distance = np.linalg.norm(floor[:, None] - centres, axis=2)
        before, second = second, distance[:, 1] < distance[:, 0]
        if (second == before).all() or second.all() or not second.any():
            break
        centres = np.stack([floor[~second].mean(axis=0), floor[second].mean(axis=0)])
    return second
