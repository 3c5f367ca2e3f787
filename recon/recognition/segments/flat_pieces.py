"""Flat pieces of an object and the remainder between them."""

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError, cKDTree

from recon.geometry import WORLD_UP
from recon.recognition.connectivity import grouped, joined
from recon.recognition.segments.local_planes import local_planes, surroundings
from recon.recognition.segments.outer_planes import outer_planes
from recon.recognition.segments.peeling import LINK_CELLS, ON_PLANE_CELLS, peeled
from recon.recognition.segments.plane_votes import largest_group
from recon.records import Cylinder, Plane, Solid, Voxels

Array = NDArray[np.float64]
Rows = NDArray[np.intp]
Step = Literal["board", "upright", "any", "outer"]
"""A level board; upright planes; planes of any tilt; the slopes of a gabled roof."""

NEIGHBOUR_CELLS = 3.5
"""Maximum distance of the cells that a plane is first fitted to: some 40 are so near on a
surface."""
LEAST_PLANE, LEAST_SHARE = 8, 0.03
"""Minimum number of cells of a plane, and their minimum share of the object's."""
LEAST_BAR = 3
BAR_SHAPES = frozenset({"box", "cylinder"})
FILLED = 0.5
"""Minimum share of a board's area with cells: a ring of walls has few."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FlatPiece:
    """A plane patch, an upright bar, or a convex piece."""

    rows: Rows
    """Cells of the object."""
    solid: Solid
    low: Array
    """(3,) corner of its box along the axes."""
    high: Array

    @cached_property
    def middle(self) -> float:
        """Height of its middle."""
        return float(self.low[1] + self.high[1]) / 2.0

    @cached_property
    def tilt_deg(self) -> float | None:
        """Angle between a plane's normal and the vertical; None for another solid."""
        if not isinstance(self.solid, Plane):
            return None
        return math.degrees(math.acos(min(abs(float(self.solid.normal[1])), 1.0)))

    @cached_property
    def slenderness(self) -> float:
        """Height of its box over the diagonal of its base."""
        x, y, z = (self.high - self.low).tolist()
        return float(y / max(math.hypot(x, z), 1e-9))


@dataclass(frozen=True, kw_only=True, eq=False)
class FlatPieces:
    """An object taken apart into planes and bars."""

    cells: Voxels
    """Of the object."""
    around: tuple[Rows, Rows]
    """The cells near each."""
    planes: tuple[FlatPiece, ...] = ()
    """By step, and of each step by descending size."""
    rest: Rows
    """Cells on none of them."""
    is_outer: bool = False
    """True if the first of them were found by what they touch, and not as surfaces."""
    _known: dict[Step, "FlatPieces"] = field(default_factory=dict)
    """The pieces after each step taken so far: ways that begin alike share these."""

    def of(self, shapes: Collection[str]) -> Sequence[FlatPiece]:
        """The pieces that may have one of some shapes: planes or, as boxes and cylinders, bars."""
        if "plane" in shapes:
            return self.planes
        return self.bars if BAR_SHAPES.intersection(shapes) else ()

    @cached_property
    def bars(self) -> tuple[FlatPiece, ...]:
        """Upright bars between the planes."""
        return tuple(_bars(self.cells, self.rest))

    def then(self, step: Step) -> "FlatPieces":
        """The same with the planes of one step among the rest, by descending size; itself if none.

        Stereo errors are along the rays, which are nearly level, so heights are the most accurate,
        and the tilt of a low board the least.
        """
        if step not in self._known:
            self._known[step] = self._after(step)
        return self._known[step]

    def _after(self, step: Step) -> "FlatPieces":
        planes, is_left = list(self.planes), np.ones(len(self.rest), np.bool_)
        for plane, own in _found(self, step, max(LEAST_PLANE, int(LEAST_SHARE * len(self.cells)))):
            planes.append(piece_of(self.cells, self.rest[own], plane))
            is_left[own] = False
        if is_left.all():
            return self
        return replace(
            self,
            planes=tuple(planes),
            rest=self.rest[is_left],
            is_outer=self.is_outer or step == "outer",
            _known={},
        )


def unsplit(cells: Voxels) -> FlatPieces:
    """An object before planes are taken from it."""
    around = surroundings(cells.means, NEIGHBOUR_CELLS * cells.cell_size)
    return FlatPieces(cells=cells, around=around, rest=np.arange(len(cells)))


def _found(pieces: FlatPieces, step: Step, least: int) -> Iterator[tuple[Plane, Rows]]:
    """Planes of one step in the rest, and their rows of it."""
    points, cell_size = pieces.cells.means[pieces.rest], pieces.cells.cell_size
    if step == "outer":
        yield from _outer(points, cell_size, least)
    elif step != "board":
        choice = _choice(pieces, points, is_upright=step == "upright")
        yield from _peeled(points, choice, step, cell_size, least)
    elif len(points) >= least:
        board = _board(points, cell_size, least)
        yield from [] if board is None else [board]


def _outer(points: Array, cell_size: float, least: int) -> Iterator[tuple[Plane, Rows]]:
    """The slopes of a roof and their points."""
    places, normals, number = outer_planes(points, cell_size, least)
    for plane, (place, normal) in enumerate(zip(places, normals, strict=True)):
        own = np.flatnonzero(number == plane)
        if len(own) >= least:
            yield Plane(point=place, normal=normal), own


def _peeled(
    points: Array, choice: tuple[Array, Array], step: Step, cell_size: float, least: int
) -> Iterator[tuple[Plane, Rows]]:
    """Planes of any tilt, or upright, and their points."""
    places, directions, number = peeled(points, *choice, step == "upright", cell_size, least)
    for plane, (place, direction) in enumerate(zip(places, directions, strict=True)):
        yield Plane(point=place, normal=direction), np.flatnonzero(number == plane)


def _choice(pieces: FlatPieces, points: Array, is_upright: bool) -> tuple[Array, Array]:
    """Points and normals (P, 3) of planes to choose from; row n, modulo N, is that of point n.

    They are the planes of the points' neighbourhoods, and the level ones through the points: a low
    rim has no neighbourhood that shows its plane.
    """
    reach = ON_PLANE_CELLS * pieces.cells.cell_size
    middles, normals = local_planes(
        pieces.cells.means, pieces.around, pieces.rest, is_upright, reach
    )
    if is_upright:
        return middles, normals
    level = np.broadcast_to(np.array(WORLD_UP), points.shape)
    return np.concatenate([middles, points]), np.concatenate([normals, level])


def _board(points: Array, cell_size: float, least: int) -> tuple[Plane, Rows] | None:
    """The level board with the most points and these; None if none is dense enough."""
    heights = np.sort(points[:, 1])
    reach = ON_PLANE_CELLS * cell_size
    counts = np.searchsorted(heights, heights + 2.0 * reach, side="right") - np.arange(len(points))
    middle = heights[int(np.argmax(counts))] + reach
    rows = np.flatnonzero(np.abs(points[:, 1] - middle) <= reach)
    rows = rows[largest_group(points[rows], LINK_CELLS * cell_size)]
    if len(rows) < least or len(rows) < FILLED * _footprint(points[rows]) / cell_size**2:
        return None
    return Plane(point=points[rows].mean(axis=0), normal=np.array(WORLD_UP)), rows


def _footprint(points: Array) -> float:
    """Area that points cover when seen from above."""
    try:
        return float(ConvexHull(points[:, ::2]).volume)
    except QhullError:
        return 0.0


def _bars(cells: Voxels, rest: Rows) -> list[FlatPiece]:
    """Upright bars in what is left, each the cells that hang together.

    Only the fuller half of the cells links: those of few points are noise between two bars, and
    belong to the nearest of them.
    """
    full = rest[cells.counts[rest] >= np.median(cells.counts[rest])] if len(rest) else rest
    if not len(full):
        return []
    tree, reach = cKDTree(cells.means[full]), LINK_CELLS * cells.cell_size
    label = joined(tree.query_pairs(reach, output_type="ndarray"), len(full))
    _, nearest = tree.query(cells.means[rest], distance_upper_bound=reach)
    label = np.append(label, np.int32(-1))[nearest]
    groups = [rest[rows] for rows in grouped(label, int(label.max()) + 1) if len(rows) >= LEAST_BAR]
    return [piece_of(cells, rows, _bar(cells.means[rows])) for rows in groups]


def _bar(points: Array) -> Cylinder:
    middle = points.mean(axis=0)
    radius = float(np.median(np.hypot(*(points - middle)[:, ::2].T)))
    low, high = points[:, 1].min(), points[:, 1].max()
    return Cylinder(
        point=np.array([middle[0], low, middle[2]]),
        axis=np.array(WORLD_UP),
        radius=radius,
        height=float(high - low),
    )


def piece_of(cells: Voxels, rows: Rows, solid: Solid) -> FlatPiece:
    """A piece of an object with its box."""
    points = cells.means[rows]
    return FlatPiece(rows=rows, solid=solid, low=points.min(axis=0), high=points.max(axis=0))
