"""Components that are two objects, and objects that are two components."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from recon.recognition.naming import Naming
from recon.records import UNKNOWN, Voxels
from recon.settings import RecognitionSettings

Array = NDArray[np.float64]
Rows = NDArray[np.intp]
Piece = tuple[Naming, Rows]

LONG = 1.5
"""Length over width of a footprint, in standard deviations, from which it may be two objects."""
INSIDE = 0.7
"""Two fits whose axes are nearer than this share of the wider one's radius are one object."""
MOST_OBJECTS = 8
"""Of one component: bounds the work on the cells of a street or a wall."""


def separate(
    whole: Piece, voxels: Voxels, settings: RecognitionSettings, name: Callable[[Rows], Naming]
) -> list[Piece]:
    """The objects that a piece of the map is: itself, or more where more fit better.

    Parameters
    ----------
    name : Callable
        Names the object that some rows of `voxels` are.
    """
    waiting: list[Piece] = [whole]
    done: list[Piece] = []
    while waiting:
        piece = waiting.pop()
        room = len(waiting) + len(done) + 2 <= MOST_OBJECTS
        halves = _halves(piece, voxels, settings.min_voxels, name) if room else []
        waiting.extend(halves)
        if not halves:
            done.append(piece)
    return done


def reunite(pieces: list[Piece], name: Callable[[Rows], Naming]) -> list[Piece]:
    """Pieces that stand in one place as one object: a crown seen from two sides is one.

    Parameters
    ----------
    pieces : list of (Naming, rows)
    name : Callable
        Names the cells of some rows.
    """
    pieces = list(pieces)
    first = 0
    while first < len(pieces):
        naming, rows = pieces[first]
        others = [other for other in pieces[first + 1 :] if _in_one_place(naming, other[0])]
        if not others:
            first += 1
            continue
        pieces = [piece for piece in pieces if all(piece is not other for other in others)]
        together = np.sort(np.concatenate([rows, *(own for _, own in others)]))
        pieces.pop(first)
        pieces.insert(0, (name(together), together))
        first = 0
    return pieces


def _in_one_place(first: Naming, second: Naming) -> bool:
    apart = float(np.hypot(*(first.centre - second.centre)[::2]))
    widest = float(max(first.size[::2].max(), second.size[::2].max()))
    return apart < INSIDE * widest / 2.0


def _halves(
    whole: Piece, voxels: Voxels, min_voxels: int, name: Callable[[Rows], Naming]
) -> list[Piece]:
    """Two objects that explain the cells better than one; empty where none do."""
    naming, rows = whole
    floor = voxels.means[rows][:, ::2]
    if naming.label != UNKNOWN and _elongation(floor) < LONG:
        return []
    second = _two_means(floor)
    if min(second.sum(), (~second).sum()) < min_voxels:
        return []
    halves = [(name(part), part) for part in (rows[~second], rows[second])]
    if any(half.label == UNKNOWN for half, _ in halves):
        return []
    better = sum(half.deviance for half, _ in halves) < naming.deviance
    return halves if better else []


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
