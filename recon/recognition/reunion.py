"""Pieces of one object in several components of the map."""

import numpy as np

from recon.recognition.naming.naming import Naming
from recon.recognition.separation import EXPLAINED, Namer, Piece, stray_share
from recon.records import UNKNOWN, Voxels

TOGETHER = 0.5
"""Maximum increase of the deviance per cell for one object instead of several."""
STRAYS = 0.3
"""Share of a piece's cells far from the solids of a named object, below which the piece, unlike a
neighbour, may belong to it at any increase."""


def reunite(pieces: list[Piece], voxels: Voxels, name: Namer) -> list[Piece]:
    """Merge pieces of one object, such as a crown seen from two sides.

    Parameters
    ----------
    pieces : list of (Naming, rows)
    name : Callable
        Names the object in some rows of `voxels`.
    """
    waiting, done = list(pieces), []
    while waiting:
        piece = waiting.pop(0)
        others = [other for other in waiting if _in_one_place(piece[0], other[0])]
        # All of them, or only one: a crown is also near to the house that it touches.
        groups = [others, *([other] for other in others)] if len(others) > 1 else [others]
        unions = ((group, _union([piece, *group], voxels, name)) for group in groups if group)
        group, union = next((found for found in unions if found[1]), ([], None))
        if union is None:
            done.append(piece)
        else:
            waiting = [other for other in waiting if not any(other is one for one in group)]
            waiting.append(union)
    return done


def _union(pieces: list[Piece], voxels: Voxels, name: Namer) -> Piece | None:
    """Pieces as one object; None if that explains their cells worse, or knows none of them."""
    rows = np.sort(np.concatenate([own for _, own in pieces]))
    union = name(rows)
    num_names = sum(naming.label != UNKNOWN for naming, _ in pieces)
    if union.label == UNKNOWN and not num_names:
        return None
    most = sum(naming.deviance for naming, _ in pieces) + TOGETHER * len(rows)
    if num_names < 2 and union.label != UNKNOWN:
        strays = max(stray_share(union, voxels.select(own)) for _, own in pieces)
        most = max(most, -EXPLAINED * len(rows)) if strays < STRAYS else most
    return (union, rows) if union.deviance <= most else None


def _in_one_place(first: Naming, second: Naming) -> bool:
    """True if two pieces may be one object.

    With names, if the centre of one is inside the other. A piece without a name, or held by nothing
    visible, may be beside the other. Two without names are the ends of one object if they are no
    farther apart than one is wide: its middle was not seen.
    """
    apart = float(np.hypot(*(first.centre - second.centre)[::2]))
    widths = [float(one.size[::2].max()) for one in (first, second)]
    num_named = sum(one.label != UNKNOWN for one in (first, second))
    if num_named == 1 or first.is_hovering or second.is_hovering:
        return apart < sum(widths) / 2.0
    return apart < max(widths) / (2.0 if num_named else 1.0)
