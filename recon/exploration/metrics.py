"""The numbers of an exploration, measured against what is true in the world."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.sparse.csgraph import minimum_spanning_tree
from scipy.spatial.distance import cdist

from recon.exploration.floor import Array, Floor, Mask
from recon.exploration.state import Walk
from recon.geometry import WORLD_UP
from recon.records import FoundObject, View
from recon.world.objects import TrueObject
from recon.world.world import World

SAMPLE = 0.1
"""World units between two samples of the way."""
CONTACT = SAMPLE / 2.0
"""An eye that comes as near as this to a surface has walked into it."""


@dataclass(slots=True, kw_only=True, eq=False)
class Record:
    """What is measured while the agent walks; the agent itself never looks into it."""

    world: World
    baseline: float
    free: Mask = field(init=False)
    """(X, Z) floor cells outside the true footprints."""
    path_length: float = 0.0
    min_clearance: float = np.inf
    curve: list[tuple[int, float, float]] = field(default_factory=list)
    """Pairs taken, path walked and floor known by then."""

    def __post_init__(self) -> None:
        self.free = self.world.free_ground()

    def walk(self, start: View, end: View) -> bool:
        """Measure the way between two views; False, and nothing noted, where a thing bars it."""
        way = way_between(start, end)
        clearance = float(self.world.clearance(eyes_along(way, end, self.baseline)).min())
        if clearance < CONTACT or self.world.is_inside(end.position[None])[0]:
            return False
        self.path_length += float(np.linalg.norm(np.diff(way, axis=0), axis=1).sum())
        self.min_clearance = min(self.min_clearance, clearance)
        return True

    def note(self, num_pairs: int, floor: Floor) -> None:
        """Put a point on the curve."""
        self.curve.append((num_pairs, self.path_length, self.coverage(floor)))

    def coverage(self, floor: Floor) -> float:
        """Known free cells, as a share of all that are free; 1 where none is."""
        known = float((floor.known_free & self.free).sum())
        return known / self.free.sum() if self.free.any() else 1.0


def way_between(start: View, end: View) -> Array:
    """Corners (N, 3) of the way from one view to the next, both ends included."""
    via = end.via if isinstance(end, Walk) else np.empty((0, 3))
    return np.vstack([start.position, via, end.position])


def eyes_along(way: Array, view: View, baseline: float) -> Array:
    """(N, 3) places of both eyes, from sample to sample of a way and at the view that ends it."""
    ends, directions = [view.position], [view.target - view.position]
    for a, b in itertools.pairwise(way):
        number = 1 + int(np.ceil(np.linalg.norm(b - a) / SAMPLE))
        ends.extend(np.linspace(a, b, number))
        directions.extend([b - a] * number)
    side = np.cross(directions, WORLD_UP)
    side /= np.maximum(np.linalg.norm(side, axis=1, keepdims=True), 1e-12)
    middle = np.array(ends)
    return np.vstack([middle - baseline / 2.0 * side, middle + baseline / 2.0 * side])


def path_bound(start: View, objects: Sequence[TrueObject], viewing_distance: float) -> float:
    """A length that no tour undercuts which comes within viewing distance of every object.

    A tour joins the discs round the objects from which they can be seen, so it is no shorter than
    the shortest tree that joins them.
    """
    centres = np.array([start.position, *(found.centre for found in objects)])[:, [0, 2]]
    radii = np.array([0.0, *(max(f.size[[0, 2]]) / 2 + viewing_distance for f in objects)])
    gaps = np.maximum(cdist(centres, centres) - radii - radii[:, None], 0.0)
    # A sparse graph takes an edge of length zero for none.
    return float(minimum_spanning_tree(gaps + 1e-9).sum())


def pairs_until_objects(
    timeline: Sequence[tuple[int, Sequence[FoundObject]]], final: Sequence[FoundObject]
) -> int:
    """Pairs taken when the last of the final objects had its final label for good."""
    return max((_settled(timeline, found) for found in final), default=0)


def _settled(timeline: Sequence[tuple[int, Sequence[FoundObject]]], final: FoundObject) -> int:
    settled = timeline[-1][0]
    for num_pairs, objects in reversed(timeline):
        if not any(_is_same(found, final) for found in objects):
            break
        settled = num_pairs
    return settled


def _is_same(found: FoundObject, final: FoundObject) -> bool:
    """Whether both have one label, and the one's axis goes through the other."""
    apart = np.abs(found.centre - final.centre)[[0, 2]]
    return found.label == final.label and bool((apart <= final.size[[0, 2]] / 2).all())
