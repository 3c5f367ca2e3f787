"""Arrangement of planes: roofs span their walls; backs line their seats and end at them."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from recon.geometry import WORLD_UP
from recon.recognition.naming.kinds import Kind, PartRule
from recon.recognition.naming.probability import LINED, SPANNED, UNPIERCED
from recon.recognition.segments.flat_pieces import FlatPiece
from recon.records import Plane, Voxels

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
        if boards(below) and is_upright(above[0]):
            board, standing = boards(below)[0], above[0]
            chance *= float(LINED.chance(lined(board, standing, cells)))
            chance *= float(UNPIERCED.chance(-pierced(board, standing, cells)))
        else:
            chance *= float(SPANNED.chance(span(above, below)))
    return chance


def boards(pieces: Sequence[FlatPiece]) -> list[FlatPiece]:
    """The planes that are nearer to level than to upright."""
    return [one for one in pieces if isinstance(one.solid, Plane) and not is_upright(one)]


def is_upright(piece: FlatPiece) -> bool:
    """True of a plane that is nearer to upright than to level."""
    return (piece.tilt_deg or 0.0) > UPRIGHT_DEG


def span(above: Sequence[FlatPiece], below: Sequence[FlatPiece]) -> float:
    """Diagonal of the footprint of pieces over that of those they lie on."""
    return _diagonal(above) / max(_diagonal(below), 1e-9)


def _diagonal(pieces: Sequence[FlatPiece]) -> float:
    low = np.min([one.low for one in pieces], axis=0)
    high = np.max([one.high for one in pieces], axis=0)
    return float(np.linalg.norm((high - low)[::2]))


def lined(board: FlatPiece, standing: FlatPiece, cells: Voxels) -> float:
    """Share of a board's extent, along a plane that stands on it, over which the plane extends."""
    assert isinstance(standing.solid, Plane)
    along = np.cross(WORLD_UP, standing.solid.normal)
    own, others = (cells.means[one.rows] @ along for one in (standing, board))
    both = min(own.max(), others.max()) - max(own.min(), others.min())
    return float(both / max(np.ptp(others), 1e-9))


def pierced(board: FlatPiece, standing: FlatPiece, cells: Voxels) -> float:
    """How far a plane goes through a board: 0 where it ends at its height, or stands at its edge.

    The smaller of the share of its cells below the board and of the share of the board's cells on
    the side with fewer.
    """
    own, others = cells.means[standing.rows], cells.means[board.rows]
    assert isinstance(standing.solid, Plane)
    away = (others - own.mean(axis=0)) @ standing.solid.normal / cells.cell_size
    aside = min(np.mean(away > ASIDE_CELLS), np.mean(away < -ASIDE_CELLS))
    lower = np.mean(own[:, 1] < others[:, 1].mean() - LOWER_CELLS * cells.cell_size)
    return float(min(aside, lower))
