"""Arrangement of planes: roofs and backs line what they are on, and backs end at their seats."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from recon.geometry import WORLD_UP
from recon.recognition.naming.kinds import Kind, PartRule
from recon.recognition.naming.probability import BACK, ROOF, UNPIERCED
from recon.recognition.segments.flat_pieces import FlatPiece
from recon.records import Plane, Voxels

Array = NDArray[np.float64]

UPRIGHT_DEG = 45.0
ASIDE_CELLS, LOWER_CELLS = 0.5, 1.0
"""Distance from a plane, and from the height of a board, from which a cell is beyond it."""


def arranged(kind: Kind, parts: Sequence[tuple[PartRule, FlatPiece]], cells: Voxels) -> float:
    """Probability that planes are on those before them as their kind's are."""
    chance = 1.0
    for lower, upper in pairwise(kind.parts):
        below = [one for rule, one in parts if rule is lower and isinstance(one.solid, Plane)]
        above = [one for rule, one in parts if rule is upper and isinstance(one.solid, Plane)]
        if upper.place != "on" or not below or not above:
            continue
        share = lined(below, above, cells)
        if boards(below) and is_upright(above[0]):
            chance *= float(BACK.chance(share))
            chance *= float(UNPIERCED.chance(-pierced(boards(below)[0], above[0], cells)))
        else:
            chance *= float(ROOF.chance(share))
    return chance


def boards(pieces: Sequence[FlatPiece]) -> list[FlatPiece]:
    """The planes that are nearer to level than to upright."""
    return [one for one in pieces if isinstance(one.solid, Plane) and not is_upright(one)]


def is_upright(piece: FlatPiece) -> bool:
    """True of a plane that is nearer to upright than to level."""
    return (piece.tilt_deg or 0.0) > UPRIGHT_DEG


def lined(below: Sequence[FlatPiece], above: Sequence[FlatPiece], cells: Voxels) -> float:
    """Share of the extent of pieces over which planes on them extend, along the first of these."""
    along = _along(above[0])
    lower, upper = (
        cells.means[np.concatenate([one.rows for one in pieces])] @ along
        for pieces in (below, above)
    )
    both = min(lower.max(), upper.max()) - max(lower.min(), upper.min())
    return float(both / max(np.ptp(lower), 1e-9))


def _along(piece: FlatPiece) -> Array:
    """The level direction of a plane; any of a level plane."""
    assert isinstance(piece.solid, Plane)
    along: Array = np.cross(WORLD_UP, piece.solid.normal)
    length = float(np.linalg.norm(along))
    return along / length if length > 0.0 else np.array([1.0, 0.0, 0.0])


def pierced(board: FlatPiece, standing: FlatPiece, cells: Voxels) -> float:
    """Share by which a plane pierces a board: 0 where it ends at its height or stands at its edge.

    The smaller of the share of its cells below the board and of the share of the board's cells on
    the side with fewer.
    """
    own, others = cells.means[standing.rows], cells.means[board.rows]
    assert isinstance(standing.solid, Plane)
    away = (others - own.mean(axis=0)) @ standing.solid.normal / cells.cell_size
    aside = min(np.mean(away > ASIDE_CELLS), np.mean(away < -ASIDE_CELLS))
    lower = np.mean(own[:, 1] < others[:, 1].mean() - LOWER_CELLS * cells.cell_size)
    return float(min(aside, lower))
