"""Metrics of an exploration that need only the objects, no other ground truth."""

from collections.abc import Sequence

import numpy as np
from scipy.sparse.csgraph import minimum_spanning_tree
from scipy.spatial.distance import cdist

from recon.exploration.floor import Array
from recon.exploration.state import Walk
from recon.records import FoundObject, View
from recon.world.objects import TrueObject


def path_between(start: View, end: View) -> Array:
    """Corners (N, 3) of the path from one view to the next, including both ends."""
    via = end.via if isinstance(end, Walk) else np.empty((0, 3))
    return np.vstack([start.position, via, end.position])


def length_of(path: Array) -> float:
    """Length of a path (N, 3), world units."""
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def path_bound(start: View, objects: Sequence[TrueObject], viewing_distance: float) -> float:
    """Lower bound for the length of a tour within viewing distance of every object.

    A tour connects the discs around the objects from which they can be seen, so it is at least as
    long as the minimum spanning tree of the discs.
    """
    centres = np.array([start.position, *(found.centre for found in objects)])[:, [0, 2]]
    radii = np.array([0.0, *(max(f.size[[0, 2]]) / 2 + viewing_distance for f in objects)])
    gaps = np.maximum(cdist(centres, centres) - radii - radii[:, None], 0.0)
    # A sparse graph ignores edges of length zero.
    return float(minimum_spanning_tree(gaps + 1e-9).sum())


def pairs_until_objects(
    timeline: Sequence[tuple[int, Sequence[FoundObject]]], final: Sequence[FoundObject]
) -> int:
    """Number of pairs after which all final objects had their final labels permanently."""
    return max((_settled(timeline, found) for found in final), default=0)


def _settled(timeline: Sequence[tuple[int, Sequence[FoundObject]]], final: FoundObject) -> int:
    settled = timeline[-1][0]
    for num_pairs, objects in reversed(timeline):
        if not any(_is_same(found, final) for found in objects):
            break
        settled = num_pairs
    return settled


def _is_same(found: FoundObject, final: FoundObject) -> bool:
    """True if both have the same label and the axis of one passes through the other."""
    return found.label == final.label and all(
        abs(found.centre[axis] - final.centre[axis]) <= final.size[axis] / 2 for axis in (0, 2)
    )
