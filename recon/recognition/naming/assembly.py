"""Assemblies: kinds made of planes and other pieces on, beside and under each other."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recon.recognition.cells import trust_by_points
from recon.recognition.fitting.least_squares import student_deviance
from recon.recognition.naming.angles import squareness
from recon.recognition.naming.arrangement import arranged, boards, is_upright
from recon.recognition.naming.kinds import Kind, PartRule, Range
from recon.recognition.naming.limits import box_sizes, solid_sizes
from recon.recognition.naming.probability import EXPLAINED, FREE, SHOWN, SQUARE
from recon.recognition.naming.underside import free_below
from recon.recognition.segments.flat_pieces import FlatPiece
from recon.recognition.segments.solid_pieces import Pieces
from recon.records import Plane, Solid, Voxels

Array = NDArray[np.float64]

TOUCH_CELLS = 2.0
"""Maximum distance of adjoining pieces of one object, in cells."""
ON_SOLID_CELLS = 0.75
"""A cell within this share of the cell size is on a solid."""
CARRIES_CELLS = 0.5
"""Depth, in cells, to which what carries a board extends below its middle at least."""
MOST = 0.75
"""Minimum share of the cells of a part below the middle of what lies on it."""
LEAST_TRUST = 0.25
"""Minimum weight of a cell with few points."""
COST_OF_SOLID = 0.5
"""Seven numbers times the log of sixty, by sixty: no more cells than these are independent, and a
further solid takes up what is only noise at a crease."""
NUMBERS_OF_PIECE = 3
"""Parameters of a plane; a bar counts the same."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Assembly:
    """Pieces that make up one kind."""

    kind: Kind
    bic: float
    explained: float
    """Probability that enough cells are on its pieces, and on each required piece, that walls are
    at right angles, that what stands on legs stands on nothing else, and that parts are on others
    as those of the kind are."""
    seen: float
    """Weighted share of the cells on its pieces."""
    pieces: tuple[FlatPiece, ...]
    rules: tuple[PartRule, ...]
    """The rule that each of them fulfils."""
    is_outer: bool
    """True if some were found by what they touch: surfaces must not explain the cells better."""

    @property
    def solids(self) -> tuple[Solid, ...]:
        """Planes and bars."""
        return tuple(one.solid for one in self.pieces)

    @property
    def roles(self) -> tuple[str, ...]:
        """Of the solids."""
        return tuple(rule.role for rule in self.rules)

    @property
    def upright(self) -> list[FlatPiece]:
        """Its planes that are nearer to upright than to level."""
        return [one for one in self.pieces if is_upright(one)]

    @property
    def has_planes(self) -> bool:
        """True if one of its pieces is a plane."""
        return any(map(_is_plane, self.pieces))

    @property
    def cost(self) -> float:
        """Deviance per cell that the solids beyond the first have to save."""
        return 0.0 if self.has_planes else COST_OF_SOLID * (len(self.pieces) - 1)

    def sizes(self, cells: Voxels) -> list[dict[str, float]]:
        """Height, width, depth and radius of each piece."""
        return [box_sizes(cells.means[one.rows]) | solid_sizes(one.solid) for one in self.pieces]


def assemblies(ways: Sequence[Pieces], kind: Kind, ground: float) -> list[Assembly]:
    """The kind assembled from the pieces of an object, once per split with all its parts.

    Parameters
    ----------
    ground : float
        Height of the surface it stands on.
    """
    found = [_assembled(pieces, kind, ground) for pieces in ways]
    return [one for one in found if one is not None]


def _assembled(pieces: Pieces, kind: Kind, ground: float) -> Assembly | None:
    """The kind assembled from the pieces; None if a part is missing."""
    cells, before, shown = pieces.cells, list[FlatPiece](), 1.0
    parts: list[tuple[PartRule, FlatPiece]] = []
    touch, top = TOUCH_CELLS * cells.cell_size, float(cells.means[:, 1].max())
    for rule in kind.parts:
        own = [one for _, one in parts]
        fitting = [
            one
            for one in pieces.of(rule.shapes)
            if not _is_taken(one, own)
            and _has_form(rule, one)
            and _is_level(rule, one, ground, top)
            and _is_placed(rule, one, before, cells)
            and (not own or _touches(one, own, touch))
        ]
        fitting.sort(key=lambda one: -len(one.rows))
        before = fitting[: rule.count[1]]
        num_in_place = _num_in_place(rule, before, own, cells)
        if num_in_place < rule.count[0] or not _is_share(rule, before, cells):
            return None
        parts += [(rule, one) for one in before]
        shown *= _shown(before[: rule.count[0]])
        shown *= float(SQUARE.chance(squareness(before))) if rule.square else 1.0
    own = [one for _, one in parts]
    trust = trust_by_points(cells, (LEAST_TRUST, 1.0))
    share = sum(_explained(one, cells, trust) for one in own) / float(trust.sum())
    shown *= _on_legs(kind, own, cells) * arranged(kind, parts, cells)
    return Assembly(
        kind=kind,
        bic=bic_of_pieces(cells, own),
        explained=float(EXPLAINED.chance(share)) * shown,
        seen=share,
        pieces=tuple(own),
        rules=tuple(rule for rule, _ in parts),
        is_outer=pieces.is_outer,
    )


def _is_taken(piece: FlatPiece, own: list[FlatPiece]) -> bool:
    """True if the cells of a piece are those of a part already."""
    return any(piece.rows is one.rows for one in own)


def _explained(piece: FlatPiece, cells: Voxels, trust: Array) -> float:
    """Trust in a piece's cells on its solid: what remains between planes need not be a bar."""
    away = piece.solid.distances(cells.means[piece.rows])
    on_it = away < ON_SOLID_CELLS * cells.cell_size
    return float(trust[piece.rows[on_it]].sum())


def _shown(needed: list[FlatPiece]) -> float:
    """Probability that the planes among the required pieces have enough cells."""
    counts = [len(one.rows) for one in needed if _is_plane(one)]
    return float(SHOWN.chance(np.log(counts)).prod()) if counts else 1.0


def _on_legs(kind: Kind, pieces: list[FlatPiece], cells: Voxels) -> float:
    """Probability that the boards of a kind with legs are no slices of something solid."""
    if all(rule.place != "under" for rule in kind.parts):
        return 1.0
    return float(np.prod([FREE.chance(free_below(one, cells)) for one in boards(pieces)]))


def _num_in_place(
    rule: PartRule, found: Sequence[FlatPiece], own: Sequence[FlatPiece], cells: Voxels
) -> int:
    """Number of the pieces found for a part; of what is under others, those that carry a board.

    What is under a back may be above the seat: clumps over a floor do not make a bench of it. Bits
    of a back that are taken for more legs than a kind needs do no harm.
    """
    carried = boards(own)
    if rule.place != "under" or not carried:
        return len(found)
    height = max(one.middle for one in carried)
    height -= CARRIES_CELLS * cells.cell_size
    return sum(float(one.low[1]) < height for one in found)


def _is_plane(piece: FlatPiece) -> bool:
    return isinstance(piece.solid, Plane)


def _touches(piece: FlatPiece, others: list[FlatPiece], touch: float) -> bool:
    """True where a piece is near one of the parts found so far."""
    gaps = [np.maximum(piece.low - one.high, one.low - piece.high).max() for one in others]
    return bool(min(gaps) <= touch)


def _has_form(rule: PartRule, piece: FlatPiece) -> bool:
    """True if the slenderness of a piece, and the tilt of a plane, fit a part."""
    if piece.tilt_deg is not None:
        is_tilted = _is_within(rule.tilt_deg, piece.tilt_deg)
        return is_tilted and _is_within(rule.slenderness, piece.slenderness)
    sizes = solid_sizes(piece.solid)
    ratio = sizes["height"] / sizes["radius"] if {"height", "radius"} <= sizes.keys() else None
    return ratio is None or _is_within(rule.slenderness, ratio)


def _is_within(bounds: Range | None, value: float) -> bool:
    return bounds is None or bounds[0] <= value <= bounds[1]


def _is_level(rule: PartRule, piece: FlatPiece, ground: float, top: float) -> bool:
    """True if the middle of a piece is at a height of its part: a seat is not low on the ground."""
    return _is_within(rule.level, (piece.middle - ground) / max(top - ground, 1e-9))


def _is_placed(rule: PartRule, piece: FlatPiece, before: list[FlatPiece], cells: Voxels) -> bool:
    """True where a piece lies on, beside or under the part before it.

    Most of a part is below what lies on it: a shelf between two walls is not their roof. What is
    under it may be beside its lower half: the back of a bench extends down to the ground. The
    middle of what is beside it is at one of its heights: a crown is not beside its trunk.
    """
    if not before:
        return True
    middle = piece.middle
    if rule.place == "beside":
        return any(bool(one.low[1] <= middle <= one.high[1]) for one in before)
    if rule.place == "under":
        ends = [one.low[1] for one in before], [one.high[1] for one in before]
        return middle < float(min(ends[0]) + max(ends[1])) / 2.0
    heights = np.concatenate([cells.means[one.rows, 1] for one in before])
    return bool((heights < middle + cells.cell_size / 2.0).mean() > MOST)


def _is_share(rule: PartRule, own: list[FlatPiece], cells: Voxels) -> bool:
    low, high = rule.share or (0.0, 1.0)
    return low <= sum(len(one.rows) for one in own) / len(cells) <= high


def bic_of_pieces(cells: Voxels, pieces: Sequence[FlatPiece]) -> float:
    """BIC of the distances of all cells to the nearest piece."""
    away = np.min([one.solid.distances(cells.means) for one in pieces], axis=0)
    numbers = NUMBERS_OF_PIECE * len(pieces)
    return student_deviance(away, 0.05 * cells.cell_size) + numbers * float(np.log(len(cells)))
